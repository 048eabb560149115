"""The contract every friction law keeps, run on all of them from their own declarations."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mjfriction.errors import LawError
from mjfriction.laws.catalog import LAWS, find_law
from mjfriction.laws.law import Law

every_law = pytest.mark.parametrize("law", LAWS.values(), ids=LAWS.keys())


def draw(law: Law, seed: int) -> np.ndarray:
    rng = np.random.default_rng(seed)
    values = {parameter.name: float(rng.uniform(*parameter.typical)) for parameter in law.parameters}
    for rule in law.orderings:
        values[rule.larger] = max(values[rule.larger], values[rule.smaller])
    return law.pack(values)


def step(law: Law, v: float, p: np.ndarray, z: np.ndarray, h: float) -> tuple[float, float, np.ndarray]:
    z_next = np.empty_like(z)
    torque, slope = law.advance(v, 0.0, z, h, p, z_next)
    return torque, slope, z_next


@every_law
def test_finite_on_all_bounds(law: Law) -> None:
    ends = [
        [max(p.lower, -1e6), min(p.upper, 1e6)] if p.name != "stribeck_exponent" else [p.lower, p.upper]
        for p in law.parameters
    ]
    for corner in itertools.product(*ends):
        for v in (0.0, 1e-12, -1e-12, 3.0, -500.0):
            assert math.isfinite(law.steady(v, 0.0, np.array(corner)))


@every_law
@given(seed=st.integers(0, 10**6), v=st.floats(-50.0, 50.0))
def test_odd_where_claimed_and_slope_not_negative(law: Law, seed: int, v: float) -> None:
    p, z = draw(law, seed), np.zeros(law.state_count)
    torque, slope, _ = step(law, v, p, z, 1e-3)
    assert slope >= 0.0
    if law.odd:
        opposite, same_slope, _ = step(law, -v, p, z, 1e-3)
        assert opposite == -torque
        assert same_slope == slope


@every_law
@given(seed=st.integers(0, 10**6), v=st.floats(-20.0, 20.0))
def test_held_velocity_reaches_steady(law: Law, seed: int, v: float) -> None:
    p, z = draw(law, seed), np.zeros(law.state_count)
    for _ in range(200):
        torque, _, z = step(law, v, p, z, 0.05)
    assert torque == pytest.approx(law.steady(v, 0.0, p), rel=1e-6, abs=1e-9)


@every_law
def test_two_half_steps_are_one_step_where_claimed(law: Law) -> None:
    if not law.exact_state:
        pytest.skip("the law does not claim an exact state step")
    p, z = draw(law, 3), np.zeros(law.state_count)
    whole = step(law, 0.4, p, z, 1e-2)
    half = step(law, 0.4, p, step(law, 0.4, p, z, 5e-3)[2], 5e-3)
    assert half[0] == pytest.approx(whole[0], rel=1e-12)
    np.testing.assert_allclose(half[2], whole[2], rtol=1e-12)


@every_law
@given(seed=st.integers(0, 10**6), amplitude=st.floats(1e-3, 5.0))
def test_a_closed_cycle_dissipates(law: Law, seed: int, amplitude: float) -> None:
    p, z = draw(law, seed), np.zeros(law.state_count)
    phase = np.linspace(0.0, 4.0 * np.pi, 2001)
    v = amplitude * np.cos(phase)
    work = 0.0
    for k, velocity in enumerate(v[:-1]):
        torque, _, z = step(law, velocity, p, z, phase[1])
        work += torque * velocity if k >= 1000 else 0.0  # the second cycle: the first may load the state
    assert work >= 0.0


@every_law
def test_compiled_equals_interpreted_and_batch_equals_loop(law: Law) -> None:
    p = draw(law, 11)
    v = np.random.default_rng(0).normal(0.0, 2.0, 200)
    load = np.zeros_like(v)
    batch = law.along(v, load, p)
    assert batch.tolist() == [law.steady(x, 0.0, p) for x in v]
    interpreted = law.steady.py_func  # type: ignore[attr-defined]
    np.testing.assert_allclose([interpreted(x, 0.0, p) for x in v], batch, rtol=1e-14)


@every_law
def test_every_parameter_is_declared_in_full(law: Law) -> None:
    assert law.summary
    assert law.formula
    assert law.source
    for parameter in law.parameters:
        assert parameter.meaning
        assert parameter.unit
        low, high = parameter.typical
        assert parameter.lower <= low < high <= parameter.upper


@every_law
def test_what_is_not_allowed_is_named(law: Law) -> None:
    good = {p.name: float(np.mean(p.typical)) for p in law.parameters}
    for rule in law.orderings:
        good[rule.larger] = 2.0 * good[rule.smaller]
    for parameter in law.parameters:
        for bad in (math.nan, math.inf, parameter.lower - 1.0):
            if math.isinf(bad) and bad < 0:
                continue
            with pytest.raises(LawError, match=f"elbow: law '{law.name}', parameter '{parameter.name}'.*allowed is"):
                law.pack({**good, parameter.name: bad}, where="elbow")
        with pytest.raises(LawError, match=f"needs '{parameter.name}'"):
            law.pack({name: value for name, value in good.items() if name != parameter.name})
    with pytest.raises(LawError, match="has no parameter 'colomb'"):
        law.pack({**good, "colomb": 1.0})
    for rule in law.orderings:
        with pytest.raises(LawError, match=f"'{rule.larger}' = .* is smaller than '{rule.smaller}'"):
            law.pack({**good, rule.larger: 0.5 * good[rule.smaller]})


def test_unknown_law_suggests_the_nearest() -> None:
    with pytest.raises(LawError, match="did you mean 'stribeck'"):
        find_law("stribek")


@given(v=st.floats(-5.0, 5.0), coulomb=st.floats(0.0, 10.0), viscous=st.floats(0.0, 10.0))
def test_laws_have_coulomb_viscous_as_their_limit(v: float, coulomb: float, viscous: float) -> None:
    plain = LAWS["coulomb_viscous"].steady(v, 0.0, np.array([coulomb, viscous]))
    limits = {
        "stribeck": [coulomb, coulomb, 0.1, 2.0, viscous],
        "quadratic_viscous": [coulomb, viscous, 0.0],
        "asymmetric": [coulomb, coulomb, viscous, viscous],
        "load_dependent": [coulomb, 0.0, viscous],
    }
    for name, parameters in limits.items():
        assert LAWS[name].steady(v, 0.0, np.array(parameters)) == pytest.approx(plain, rel=1e-12, abs=1e-12)


def test_stribeck_starts_at_static_and_ends_at_coulomb() -> None:
    p = np.array([3.0, 5.0, 0.1, 2.0, 0.7])
    steady = LAWS["stribeck"].steady
    assert steady(1e-9, 0.0, p) == pytest.approx(5.0)
    assert steady(0.1, 0.0, p) == pytest.approx(3.0 + 2.0 * math.exp(-1.0) + 0.07)
    assert steady(10.0, 0.0, p) == pytest.approx(10.0)


def test_load_presses_alike_from_either_side() -> None:
    p = np.array([1.0, 0.1, 0.5])
    steady = LAWS["load_dependent"].steady
    assert steady(2.0, 30.0, p) == pytest.approx(5.0)
    assert steady(2.0, -30.0, p) == steady(2.0, 30.0, p) == -steady(-2.0, 30.0, p)
