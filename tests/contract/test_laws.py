"""The contract every friction law keeps, run on all of them from their own declarations."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import brentq, least_squares

from mjfriction.errors import LawError
from mjfriction.laws.ambient import ambient
from mjfriction.laws.catalog import LAWS, find_law
from mjfriction.laws.dispatch import advance_of, steady_of
from mjfriction.laws.law import Law
from scripts.law_costs import plain
from tests.contract.draws import draw, named

every_law = pytest.mark.parametrize("law", LAWS.values(), ids=LAWS.keys())
dynamic = [law for law in LAWS.values() if law.states + law.states_per_element]
every_dynamic_law = pytest.mark.parametrize("law", dynamic, ids=[law.name for law in dynamic])
ROOM = ambient(1)[0]


def rest(law: Law, p: np.ndarray) -> np.ndarray:
    return np.zeros(law.state_count(p))


def step(law: Law, v: float, p: np.ndarray, z: np.ndarray, h: float) -> tuple[float, float, np.ndarray]:
    z_next = np.full_like(z, np.nan)
    torque, slope = law.advance(v, ROOM, z, h, p, z_next)
    return torque, slope, z_next


@every_law
def test_finite_on_all_bounds(law: Law) -> None:
    far = 1e6
    declared = [*law.parameters, *(p for p in law.elements for _ in range(2))]
    ends = [[max(p.lower, -far), min(p.upper, far)] for p in declared]
    rng = np.random.default_rng(0)
    corners = list(itertools.product(*ends)) if len(ends) <= 8 else [[rng.choice(e) for e in ends] for _ in range(256)]
    hot = ambient(1, load=-far, position=far, temperature=far, pressure_head=far, pressure_rod=far)[0]
    for corner in corners:
        p = np.array(corner, dtype=float)
        for v, around in itertools.product((0.0, 1e-12, -1e-12, 3.0, -500.0), (ROOM, hot)):
            z_next = rest(law, p)
            assert math.isfinite(law.steady(v, around, p)), (corner, v)
            for h in (1e-6, 1e-3, 10.0):
                torque, slope = law.advance(v, around, rest(law, p), h, p, z_next)
                assert math.isfinite(torque), (corner, v, h)
                assert slope >= 0.0, (corner, v, h)
                assert np.all(np.isfinite(z_next)), (corner, v, h)


@every_law
@given(seed=st.integers(0, 10**6), v=st.floats(-50.0, 50.0))
def test_odd_where_claimed_and_slope_not_negative(law: Law, seed: int, v: float) -> None:
    p = draw(law, seed)
    z = rest(law, p)
    for _ in range(3):
        torque, slope, after = step(law, v, p, z, 1e-3)
        assert slope >= 0.0
        if law.odd:
            opposite, same_slope, mirrored = step(law, -v, p, -z if law.name != "dwell_time" else z * [-1, 1, 1], 1e-3)
            assert opposite == -torque
            assert same_slope == slope
            assert abs(mirrored[0] if mirrored.size else 0.0) == abs(after[0] if after.size else 0.0)
        z = after


@every_law
@given(seed=st.integers(0, 10**6), v=st.floats(-20.0, 20.0))
def test_held_velocity_reaches_steady(law: Law, seed: int, v: float) -> None:
    if 0.0 < abs(v) < 1e-6:
        return  # within the rest band a law holds whatever holds; near it, travel takes longer than the test
    p = draw(law, seed)
    z = rest(law, p)
    for k in range(200):  # ever longer steps: Dahl's spring with a high exponent takes its last share very slowly
        torque, _, z = step(law, v, p, z, 0.05 * 1.3**k)
    steady = law.steady(v, ROOM, p)
    if law.name == "lugre_smooth":
        assert torque == pytest.approx(steady, rel=1e-5, abs=1e-6)  # 1/K_v still shows
    else:
        assert torque == pytest.approx(steady, rel=1e-6, abs=1e-9)


@every_law
@given(seed=st.integers(0, 10**6), v=st.floats(-3.0, 3.0), h=st.floats(1e-5, 1.0), before=st.floats(-1.0, 1.0))
def test_two_half_steps_are_one_step_where_claimed(law: Law, seed: int, v: float, h: float, before: float) -> None:
    if not law.exact_state or abs(v) < 1e-9:
        return
    p = draw(law, seed)
    _, _, z = step(law, before, p, rest(law, p), 1e-3)
    whole = step(law, v, p, z, h)[2]
    half = step(law, v, p, step(law, v, p, z, h / 2)[2], h / 2)[2]
    np.testing.assert_allclose(half, whole, rtol=1e-9, atol=1e-12 * max(1.0, float(np.max(np.abs(z), initial=0.0))))


@every_law
@given(seed=st.integers(0, 10**6), amplitude=st.floats(1e-3, 5.0))
def test_a_closed_cycle_dissipates(law: Law, seed: int, amplitude: float) -> None:
    p = draw(law, seed)
    phase = np.linspace(0.0, 4.0 * np.pi, 2001)
    v = amplitude * np.cos(phase[:-1])
    torque, _ = law.follow(v, ambient(v.size), phase[1], p)
    assert float(np.sum(torque[1000:] * v[1000:])) >= 0.0  # the second cycle: the first may load the state


@every_law
def test_compiled_equals_interpreted_and_batch_equals_loop(law: Law) -> None:
    p = draw(law, 11)
    v = np.random.default_rng(0).normal(0.0, 2.0, 200)
    batch = law.along(v, ambient(v.size), p)
    assert batch.tolist() == [law.steady(x, ROOM, p) for x in v]
    steady, advance = plain(law, "steady"), plain(law, "advance")
    np.testing.assert_allclose([steady(x, ROOM, p) for x in v], batch, rtol=1e-13)
    torque, states = law.follow(v, ambient(v.size), 1e-3, p)
    z = rest(law, p)
    for k, x in enumerate(v):
        by_call, _, z_call = step(law, x, p, z, 1e-3)
        z_next = np.empty_like(z)
        slow, _ = advance(x, ROOM, z, 1e-3, p, z_next)
        assert by_call == torque[k]
        assert z_call.tolist() == states[k].tolist()
        assert slow == pytest.approx(torque[k], rel=1e-9, abs=1e-9)
        z = z_call


@every_law
def test_the_common_door_leads_to_the_law(law: Law) -> None:
    number, p = list(LAWS).index(law.name), draw(law, 5)
    for v in (-2.0, 0.0, 1e-11, 0.3):
        z, one, other = rest(law, p), rest(law, p), rest(law, p)
        direct = law.advance(v, ROOM, z, 1e-3, p, other)
        room, state, values, after = (own.ctypes.data for own in (ROOM, z, p, one))
        door = advance_of(number, v, room, state, z.size, 1e-3, values, p.size, after)
        assert steady_of(number, v, ROOM, p) == pytest.approx(law.steady(v, ROOM, p), rel=1e-13)
        assert door == pytest.approx(direct, rel=1e-13)
        np.testing.assert_allclose(one, other, rtol=1e-13)


def test_the_numbers_of_laws_never_change() -> None:
    order = """
    coulomb coulomb_viscous static_kinetic stribeck lorentzian quadratic_viscous power_viscous saturating_viscous
    asymmetric load_dependent geared_load temperature_dependent position_dependent arctan arctan_load pressure
    dahl lugre lugre_lorentzian lugre_arctan lugre_smooth elasto_plastic maxwell_slip leuven gms dwell_time
    pressed_seals asymmetric_curve
    """
    assert list(LAWS) == order.split()
    assert math.isnan(steady_of(len(LAWS), 1.0, ROOM, np.zeros(3)))


@every_law
def test_it_sticks_under_half_its_level(law: Law) -> None:
    """A joint of inertia J with h²σ₀/J = 400 under half the breakaway torque, stepped implicitly: it comes to rest."""
    if law.name == "lugre_smooth":
        pytest.skip("creeps below 1/K_v, as its description says")
    values = named(law, 1)
    if law.name == "static_kinetic":
        values["level"] = 5.0
    if "coulomb" in values and "static" in values:  # else half the breakaway torque may keep it sliding
        values["coulomb"] = 0.8 * values["static"]
    p, h = law.pack(values), 1e-3
    load = 0.5 * abs(law.steady(1e-9, ROOM, p)) if law.name != "dwell_time" else 0.5 * p[1]
    stiffness = step(law, 0.0, p, rest(law, p), h)[1] / h if rest(law, p).size else 1e3
    inertia = h * h * stiffness / 400.0
    v, z = 0.02, rest(law, p)
    for _ in range(4000):
        free = v + h * load / inertia

        def residual(x: float, z: np.ndarray = z, free: float = free) -> float:
            return inertia * (x - free) + h * step(law, x, p, z, h)[0]

        reach = 1.0 + abs(free)
        v = float(brentq(residual, -reach, reach, xtol=1e-18, rtol=1e-14))
        z = step(law, v, p, z, h)[2]
    assert abs(v) < 1e-9


@every_dynamic_law
def test_order_of_convergence_is_one(law: Law) -> None:
    p, end = draw(law, 2), 0.7

    def torque(steps: int) -> np.ndarray:
        t = np.linspace(0.0, end, steps + 1)[1:]
        v = 0.02 * np.sin(9.0 * t) + 0.01 * np.sin(23.0 * t)
        return law.follow(v, ambient(steps), end / steps, p)[0][steps // 256 - 1 :: steps // 256]

    fine = torque(2**20)
    errors = [float(np.mean(np.abs(torque(2**k) - fine))) for k in (12, 13, 14, 15)]
    order = -float(np.polyfit(range(4), np.log2(errors), 1)[0])
    assert order == pytest.approx(1.0, abs=0.2)


IDENTIFIED = [law for law in LAWS.values() if law.name not in {"pressure", "lugre_smooth", "arctan_load"}]


@pytest.mark.parametrize("law", IDENTIFIED, ids=[law.name for law in IDENTIFIED])
def test_hidden_values_are_recovered_within_the_stated_interval(law: Law) -> None:
    """Least squares on torque with white noise finds every value within five standard errors of the truth."""
    rng = np.random.default_rng(4)
    values = named(law, 8, elements=2)
    if "stribeck_velocity" in values:
        values["stribeck_velocity"] = 0.1
    truth = law.pack(values)
    t = np.arange(0.0, 6.0, 2e-3)
    v = 0.5 * np.sin(3.0 * t) * np.sin(0.5 * t) + 1e-3 * np.sin(31.0 * t) * (t < 2.0)
    around = ambient(
        t.size,
        load=5.0 * np.sin(2.1 * t),
        position=np.cumsum(v) * 2e-3,
        temperature=20.0 + 5.0 * t,
        pressure_head=4e6 + 2e6 * np.sin(1.3 * t),
        pressure_rod=4e6 + 2e6 * np.sin(2.9 * t),
    )
    fixed = [law.index(name) for name in ("sign_sharpness", "reference_temperature", "damping_velocity")]
    fixed += [law.index("rise_time"), law.index("static_rested")] if law.name == "dwell_time" else []
    fixed += [truth.size - 2, truth.size - 1] if law.name == "leuven" else []  # it slides before its elements slip
    free = [i for i in range(truth.size) if i not in fixed and truth[i] != 0.0]

    def torque(p: np.ndarray) -> np.ndarray:
        return law.follow(v, around, 2e-3, p)[0] if rest(law, p).size else law.along(v, around, p)

    noise = 1e-3 * float(np.std(torque(truth)))
    measured = torque(truth) + rng.normal(0.0, noise, t.size)

    def residual(scale: np.ndarray) -> np.ndarray:
        p = truth.copy()
        p[free] *= scale
        return (torque(p) - measured) / noise

    start = 1.0 + 0.02 * rng.uniform(-1.0, 1.0, len(free))
    # Laws with branches are followed over thousands of steps: differences over less than this are their rounding.
    fit = least_squares(residual, start, x_scale="jac", bounds=(0.5, 2.0), diff_step=1e-5)
    errors = np.sqrt(np.diag(np.linalg.inv(fit.jac.T @ fit.jac)))
    assert fit.cost / t.size == pytest.approx(0.5, rel=0.1)
    assert np.all(np.abs(fit.x - 1.0) < 4.0 * errors + 1e-6), np.c_[fit.x, errors]


@every_law
def test_every_parameter_is_declared_in_full(law: Law) -> None:
    for text in (law.summary, law.formula, law.source, law.captures, law.misses):
        assert text
    for parameter in (*law.parameters, *law.elements):
        assert parameter.meaning
        assert parameter.unit
        low, high = parameter.typical
        assert parameter.lower <= low < high <= parameter.upper


@every_law
def test_what_is_not_allowed_is_named(law: Law) -> None:
    good = named(law, 3)
    p = law.pack(good)
    assert {name: pytest.approx(value) for name, value in good.items()} == law.unpack(p)
    for parameter in (*law.parameters, *law.elements):
        alone = parameter in law.parameters
        for bad in (math.nan, math.inf, parameter.lower - 1.0):
            if math.isinf(bad) and bad < 0:
                continue
            value = bad if alone else [bad, *good[parameter.name][1:]]
            name = parameter.name if alone else rf"{parameter.name}\[0\]"
            finite = "" if math.isfinite(bad) else "finite, "
            allowed = f"allowed is {finite}{parameter.allowed}"
            with pytest.raises(LawError, match=f"elbow: law '{law.name}', parameter '{name}'.*{allowed}"):
                law.pack({**good, parameter.name: value}, where="elbow")
        without = {name: value for name, value in good.items() if name != parameter.name}
        if parameter.default is None:
            with pytest.raises(LawError, match=f"needs '{parameter.name}'"):
                law.pack(without)
        else:
            assert law.pack(without)[law.parameters.index(parameter)] == parameter.default
        with pytest.raises(LawError, match=r"is one number" if alone else "is a list with one value"):
            law.pack({**good, parameter.name: [1.0, 2.0] if alone else 1.0})
        if alone:
            for other in ("8", None, True):
                with pytest.raises(LawError, match=f"'{parameter.name}' is one number, not {other!r}"):
                    law.pack({**good, parameter.name: other})  # type: ignore[dict-item]
    with pytest.raises(LawError, match="has no parameter 'colomb'"):
        law.pack({**good, "colomb": 1.0})


def test_rules_between_values_are_named() -> None:
    gms = named(LAWS["gms"], 0)
    leuven = named(LAWS["leuven"], 0)
    cases = [
        (
            "stribeck",
            {**named(LAWS["stribeck"], 0), "static": 1.0, "coulomb": 2.0},
            "'static' = 1 is smaller than 'cou",
        ),
        ("gms", {**gms, "share": [0.1, 0.2, 0.3, 0.3], "stiffness": [1e3] * 4}, "sum of 'share' is 0.9; it must be 1"),
        ("gms", {**gms, "share": [0.25] * 4, "stiffness": [1.0, 2.0, 3.0, 4.0]}, r"element 2 breaks away after"),
        ("gms", {**gms, "stiffness": [1e3, 1e3]}, "'stiffness' has 2 values and 'share' 4"),
        ("leuven", {**leuven, "level": [0.01] * 4, "stiffness": [1e3] * 4}, "below 'static'"),
        ("maxwell_slip", {"viscous": 0.0, "stiffness": [], "level": []}, "is a list with one value"),
    ]
    for name, values, message in cases:
        with pytest.raises(LawError, match=message):
            LAWS[name].pack(values)


def test_unknown_law_suggests_the_nearest() -> None:
    with pytest.raises(LawError, match="did you mean 'stribeck'"):
        find_law("stribek")


def test_a_state_of_the_wrong_size_is_refused() -> None:
    with pytest.raises(LawError, match="has 1 states here"):
        LAWS["lugre"].follow(np.zeros(3), ambient(3), 1e-3, draw(LAWS["lugre"], 0), np.zeros(2))
