"""What the papers say the laws do, and the laws against independent solutions of their equations."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from mjfriction.laws.ambient import ambient
from mjfriction.laws.catalog import LAWS
from tests.oracles import friction_equations as paper

STRIBECK = {"coulomb": 6.0, "static": 9.0, "stribeck_velocity": 0.05, "stribeck_exponent": 2.0}
BRISTLE = {"bristle_stiffness": 4e3, "bristle_damping": 12.0, "viscous": 1.5}
MANIPULATOR = {
    "static": 1.5237,
    "stribeck_fall": -0.6757,
    "viscous": 0.0027,
    "viscous_bend": -2.1e-6,
    "stribeck_steepness": 10.0972,
}  # joint 1 of the NS12, motor side
ELEMENTS = {"stiffness": [8e3, 3e3, 1e3], "level": [2.0, 3.0, 5.0]}


def follow(name: str, values: dict, v: np.ndarray, h: float) -> np.ndarray:
    law = LAWS[name]
    return law.follow(v, ambient(v.size), h, law.pack(values))[0]


def travelled(name: str, values: dict, corners: list[float], speed: float = 1e-4, h: float = 1e-3):
    """Drive the law along straight lines between corners at low speed; return position and torque."""
    v = np.concatenate(
        [np.full(round(abs(b - a) / (speed * h)), math.copysign(speed, b - a)) for a, b in itertools.pairwise(corners)]
    )
    return np.cumsum(v) * h, follow(name, values, v, h)


def at(x: np.ndarray, torque: np.ndarray, leg: slice, position: float) -> float:
    order = np.argsort(x[leg])
    return float(np.interp(position, x[leg][order], torque[leg][order]))


# --- against Radau and Euler ---------------------------------------------------------------------------------------


def velocity(t):
    return 0.04 * np.sin(8.0 * t) + 0.03 * np.sin(21.0 * t)


TIMES = np.linspace(0.05, 0.9, 18)


def bristle_torque(rate, s0, s1):
    z = paper.integrate(rate, velocity, TIMES, max_step=2e-3)
    return s0 * z + s1 * np.array([rate(velocity(t), own) for t, own in zip(TIMES, z, strict=True)])


def radau_torque(name: str) -> tuple[np.ndarray, dict]:
    v = velocity(TIMES)
    fading = 1.0 - 2.0 / np.pi * np.arctan(10.0972 * np.abs(v))
    if name == "dahl":
        values = {"coulomb": 6.0, "bristle_stiffness": 4e3, "shape_exponent": 1.6, "viscous": 1.5}
        return paper.integrate(
            lambda v, f: paper.dahl_rate(v, f, 6.0, 4e3, 1.6), velocity, TIMES, max_step=2e-3
        ) + 1.5 * v, values
    if name == "lugre":
        rate = lambda v, z: paper.lugre_rate(v, z, paper.gaussian(v, 6.0, 9.0, 0.05, 2.0), 4e3)  # noqa: E731
        return bristle_torque(rate, 4e3, 12.0) + 1.5 * v, {**STRIBECK, **BRISTLE}
    if name == "elasto_plastic":
        rate = lambda v, z: paper.elasto_plastic_rate(  # noqa: E731
            v, z, paper.gaussian(v, 6.0, 9.0, 0.05, 2.0), 4e3, 0.6 * 6.0 / 4e3
        )
        return bristle_torque(rate, 4e3, 12.0) + 1.5 * v, {**STRIBECK, **BRISTLE, "elastic_share": 0.6}
    level = lambda v: 1.5237 - 0.6757 * np.arctan(10.0972 * abs(v))  # noqa: E731
    viscous = 0.0027 * v - 2.1e-6 * v * np.abs(v)
    z_of = {"bristle_stiffness": 900.0, "bristle_damping": 2.0}
    if name == "lugre_arctan":
        rate = lambda v, z: paper.lugre_rate(v, z, level(v), 900.0)  # noqa: E731
        damped = bristle_torque(rate, 0.0, 2.0)
        return bristle_torque(rate, 900.0, 0.0) + fading * damped + viscous, {**MANIPULATOR, **z_of}
    rate = lambda v, z: paper.smooth_rate(v, z, level(v), 900.0, 500.0)  # noqa: E731
    bend = -2.1e-6 * v * v * 2.0 / np.pi * np.arctan(500.0 * v)
    damped = bristle_torque(rate, 0.0, 2.0)
    total = bristle_torque(rate, 900.0, 0.0) + fading * damped + 0.0027 * v + bend
    return total, {**MANIPULATOR, **z_of, "sign_sharpness": 500.0}


@pytest.mark.parametrize("name", ["dahl", "lugre", "elasto_plastic", "lugre_arctan", "lugre_smooth"])
def test_small_steps_approach_radau(name: str) -> None:
    truth, values = radau_torque(name)

    def ours(steps_per_second: int) -> np.ndarray:
        h = 1.0 / steps_per_second
        t = np.arange(1, round(0.9 * steps_per_second) + 1) * h
        return follow(name, values, velocity(t), h)[np.round(TIMES / h).astype(int) - 1]

    coarse, fine = ours(20_000), ours(40_000)
    size = float(np.max(np.abs(truth)))
    assert np.max(np.abs(fine - truth)) < 5e-3 * size
    assert np.mean(np.abs(fine - truth)) < 0.6 * np.mean(np.abs(coarse - truth))
    np.testing.assert_allclose(2.0 * fine - coarse, truth, atol=2e-5 * size)


@pytest.mark.parametrize("name", ["gms", "leuven"])
def test_small_steps_approach_the_switching_rules(name: str) -> None:
    h = 5e-6
    t = np.arange(0.0, 0.5, h)
    v = velocity(t)
    level = lambda v: float(paper.gaussian(v, 6.0, 9.0, 0.05, 2.0))  # noqa: E731
    k = np.array([8e3, 3e3, 1e3])
    if name == "gms":
        truth = paper.gms_by_euler(v, h, level, k, np.array([0.2, 0.3, 0.5]), 300.0) + 1.5 * v
        values = {"attraction": 300.0, "viscous": 1.5, "stiffness": k.tolist(), "share": [0.2, 0.3, 0.5]}
    else:
        truth = paper.leuven_by_euler(v, h, level, k, np.array([2.0, 3.0, 5.0]), 12.0, 1.4) + 1.5 * v
        values = {**ELEMENTS, "bristle_damping": 12.0, "shape_exponent": 1.4, "viscous": 1.5}
    ours = follow(name, {**STRIBECK, **values}, v, h)
    assert np.max(np.abs(ours - truth)) < 3e-3 * np.max(np.abs(truth))


# --- memory --------------------------------------------------------------------------------------------------------

OUTER = [0.0, 1.0e-3, 0.2e-3, 0.6e-3, 0.2e-3, -0.6e-3]
GMS = {**STRIBECK, "attraction": 300.0, "viscous": 0.0, "stiffness": [8e3, 3e3, 1e3], "share": [0.2, 0.3, 0.5]}


def inner_loop(name: str, values: dict) -> tuple[float, float]:
    """Return by how much an inner loop fails to close, and to be wiped out, as shares of the level."""
    x, torque = travelled(name, values, OUTER)
    plain_x, plain = travelled(name, values, [0.0, 1.0e-3, -0.6e-3])
    turn = [round(s / 1e-7) for s in np.cumsum(np.abs(np.diff(OUTER)))]
    closed = abs(torque[turn[3] - 1] - torque[turn[1] - 1])
    wiped = abs(at(x, torque, slice(turn[3], None), -0.3e-3) - at(plain_x, plain, slice(turn[0], None), -0.3e-3))
    return closed / 9.0, wiped / 9.0


@pytest.mark.parametrize(
    ("name", "values", "most"),
    [
        ("maxwell_slip", {**ELEMENTS, "viscous": 0.0}, 1e-9),
        ("gms", GMS, 1e-3),
        ("leuven", {**STRIBECK, **ELEMENTS, "bristle_damping": 0.0, "shape_exponent": 15.0, "viscous": 0.0}, 5e-3),
    ],
)
def test_inner_loops_close_and_are_wiped_out(name: str, values: dict, most: float) -> None:
    closed, wiped = inner_loop(name, values)
    assert closed < most
    assert wiped < most


def test_lugre_and_dahl_have_no_such_memory() -> None:
    values = {**STRIBECK, **BRISTLE, "bristle_stiffness": 8e3, "bristle_damping": 0.0, "viscous": 0.0}
    dahl = {"coulomb": 9.0, "bristle_stiffness": 8e3, "shape_exponent": 1.0, "viscous": 0.0}
    for name, own in (("lugre", values), ("dahl", dahl)):
        assert inner_loop(name, own)[0] > 0.02  # four times what the others are allowed


def settle(name: str, values: dict, force, seconds: float, mass: float = 1.0, h: float = 1e-4, x0=0.0, spring=None):
    """A mass under ``force(t, x)`` with the law, stepped implicitly; return time, position, velocity."""
    law = LAWS[name]
    p = law.pack(values)
    z, z_next = np.zeros(law.state_count(p)), np.zeros(law.state_count(p))
    room = ambient(1)[0]
    n = round(seconds / h)
    x, v = np.empty(n), np.empty(n)
    position, speed = x0, 0.0
    for k in range(n):
        push = force((k + 1) * h, position)
        # A spring enters at the end of the step too, so that the step stays first order and stable.
        stiffness = spring or 0.0

        def residual(s, z=z, speed=speed, push=push, stiffness=stiffness):
            return mass * (s - speed) + h * (law.advance(s, room, z, h, p, z_next)[0] - push + stiffness * h * s)

        reach = abs(speed) + h * (abs(push) + 100.0) / mass + 1e-3
        speed = brentq(residual, -reach, reach, xtol=1e-16, rtol=1e-12)
        law.advance(speed, room, z, h, p, z_next)
        z = z_next.copy()
        position += h * speed
        x[k], v[k] = position, speed
    return np.arange(1, n + 1) * h, x, v


def test_lugre_drifts_under_vibration_and_elements_do_not() -> None:
    def push(t, x):
        return 4.0 + 1.2 * math.sin(2.0 * math.pi * 20.0 * t) * (t > 0.2)

    def drift(name: str, values: dict) -> float:
        _, x, _ = settle(name, values, push, 2.4, h=5e-4)
        cycle = round(0.05 / 5e-4)
        return float(np.mean(x[-cycle:]) - np.mean(x[-9 * cycle : -8 * cycle])) / 8.0

    lugre = drift("lugre", {**STRIBECK, **BRISTLE})
    assert lugre > 1e-6
    assert abs(drift("maxwell_slip", {**ELEMENTS, "viscous": 1.5})) < 0.02 * lugre
    assert abs(drift("gms", {**GMS, "viscous": 1.5})) < 0.02 * lugre
    assert abs(drift("elasto_plastic", {**STRIBECK, **BRISTLE, "elastic_share": 0.9})) < 0.02 * lugre


# --- limits --------------------------------------------------------------------------------------------------------

WALK = 0.02 * np.sin(np.linspace(0.0, 40.0, 4000)) + 0.3 * np.sin(np.linspace(0.0, 9.0, 4000))


def test_lugre_is_dahl_without_stribeck_and_damping() -> None:
    flat = {"coulomb": 6.0, "static": 6.0, "stribeck_velocity": 0.1, "stribeck_exponent": 2.0}
    lugre = follow("lugre", {**flat, "bristle_stiffness": 4e3, "bristle_damping": 0.0, "viscous": 0.0}, WALK, 1e-3)
    dahl = follow("dahl", {"coulomb": 6.0, "bristle_stiffness": 4e3, "shape_exponent": 1.0, "viscous": 0.0}, WALK, 1e-3)
    np.testing.assert_allclose(lugre, dahl, rtol=1e-9, atol=1e-10)


def test_dahl_becomes_coulomb_as_it_stiffens() -> None:
    coulomb = LAWS["coulomb_viscous"].along(WALK, ambient(WALK.size), np.array([6.0, 1.5]))
    gaps = []
    for stiffness in (1e3, 1e5, 1e7, 1e9):
        values = {"coulomb": 6.0, "bristle_stiffness": stiffness, "shape_exponent": 1.0, "viscous": 1.5}
        gaps.append(float(np.sqrt(np.mean((follow("dahl", values, WALK, 1e-3) - coulomb) ** 2))))
    assert gaps[0] > 2.0 * gaps[1] > 4.0 * gaps[2] > 8.0 * gaps[3]
    assert gaps[3] < 0.05


def test_leuven_with_one_linear_element_is_lugre() -> None:
    h = 1e-5
    v = 0.04 * np.sin(np.linspace(0.0, 14.0, 60_000))
    leuven = {"stiffness": [4e3], "level": [50.0], "bristle_damping": 12.0, "shape_exponent": 1.0, "viscous": 1.5}
    one = follow("leuven", {**STRIBECK, **leuven}, v, h)
    other = follow("lugre", {**STRIBECK, **BRISTLE}, v, h)
    np.testing.assert_allclose(one, other, atol=2e-3 * np.max(np.abs(other)))


def test_gms_is_maxwell_slip_at_low_and_stribeck_at_high_speed() -> None:
    slow = [0.0, 3e-3, -3e-3, 1e-3]
    _, gms = travelled("gms", GMS, slow, speed=1e-5, h=1e-2)
    levels = [9.0 * share for share in GMS["share"]]
    _, slip = travelled(
        "maxwell_slip", {"viscous": 0.0, "stiffness": GMS["stiffness"], "level": levels}, slow, 1e-5, 1e-2
    )
    np.testing.assert_allclose(gms, slip, atol=1e-3 * 9.0)
    t = np.arange(0.0, 40.0, 1e-3)
    v = 0.05 + 0.045 * np.sin(0.3 * t)  # slow change, always sliding
    settled = t > 5.0
    stribeck = LAWS["stribeck"].along(v, ambient(t.size), np.array([6.0, 9.0, 0.05, 2.0, 0.0]))
    np.testing.assert_allclose(follow("gms", GMS, v, 1e-3)[settled], stribeck[settled], atol=0.03 * 9.0)


def test_gms_with_one_element_is_one_spring_and_slider() -> None:
    x, torque = travelled("gms", {**GMS, "stiffness": [4e3], "share": [1.0]}, [0.0, 4e-3], speed=1e-5, h=1e-2)
    np.testing.assert_allclose(torque, np.minimum(4e3 * x, 9.0), atol=2e-3)


def test_published_numbers_of_the_manipulator_law() -> None:
    """Coulomb level at speed τ_s + (π/2)·τ_sc; the smooth law's steady curve is the static law's."""
    law = LAWS["arctan"]
    p = law.pack(MANIPULATOR)
    level = 1.5237 - 0.6757 * math.pi / 2.0
    assert law.steady(300.0, ambient(1)[0], p) - 0.0027 * 300.0 + 2.1e-6 * 9e4 == pytest.approx(level, abs=1e-3)
    smooth = LAWS["lugre_smooth"]
    own = smooth.pack({**MANIPULATOR, "bristle_stiffness": 765500.0, "bristle_damping": 1456.0})
    for v in (0.8, -7.0, 60.0):
        assert smooth.steady(v, ambient(1)[0], own) == pytest.approx(law.steady(v, ambient(1)[0], p), rel=1e-6)


def test_arctan_under_load_follows_the_torque_from_either_side() -> None:
    law = LAWS["arctan_load"]
    p = law.pack({**MANIPULATOR, "static_load": 0.05, "fall_load": -0.02})
    base = LAWS["arctan"].pack({**MANIPULATOR, "static": 1.5237 + 0.05 * 8.0, "stribeck_fall": -0.6757 - 0.02 * 8.0})
    for load in (8.0, -8.0):
        around = ambient(1, load=load)[0]
        assert law.steady(2.0, around, p) == pytest.approx(LAWS["arctan"].steady(2.0, around, base), rel=1e-12)


# --- stick-slip, breakaway, lag --------------------------------------------------------------------------------------

LUGRE_1995 = {
    "coulomb": 1.0,
    "static": 1.5,
    "stribeck_velocity": 0.001,
    "stribeck_exponent": 2.0,
    "bristle_stiffness": 1e5,
    "bristle_damping": math.sqrt(1e5),
    "viscous": 0.4,
}  # the paper's Table I


def test_stick_slip_of_the_1995_example_against_radau() -> None:
    """A mass of 1 kg drawn at 0.1 m/s through a spring of 2 N/m: period and length of the jumps."""

    def rate(t, y):
        x, v, z = y
        level = 1.0 + 0.5 * math.exp(-((v / 0.001) ** 2))
        dz = v - 1e5 * abs(v) / level * z
        return [v, 2.0 * (0.1 * t - x) - 1e5 * z - math.sqrt(1e5) * dz - 0.4 * v, dz]

    t = np.arange(0.0, 40.0, 1e-3)
    truth = solve_ivp(rate, (0.0, 40.0), [0.0, 0.0, 0.0], "Radau", t, rtol=1e-8, atol=1e-12).y[0]
    _, ours, _ = settle("lugre", LUGRE_1995, lambda t, x: 2.0 * (0.1 * t - x), 40.0, h=1e-3, spring=2.0)

    def jumps(x: np.ndarray) -> tuple[float, float]:
        slow = np.abs(np.gradient(x, 1e-3)) < 0.01
        starts = np.flatnonzero(slow[:-1] & ~slow[1:])
        ends = np.flatnonzero(~slow[:-1] & slow[1:])
        starts = starts[starts < ends[-1]][1:]
        ends = np.array([ends[ends > s][0] for s in starts])
        return float(np.mean(np.diff(starts)) * 1e-3), float(np.mean(x[ends] - x[starts]))

    period, jump = jumps(truth)
    our_period, our_jump = jumps(ours)
    assert 5.0 < period < 12.0
    assert our_period == pytest.approx(period, rel=0.01)
    assert our_jump == pytest.approx(jump, rel=0.01)


def test_breakaway_falls_with_the_rate_of_the_force() -> None:
    """The 1995 paper's varying break-away force: the faster the ramp, the lower the force at which it slips."""

    def breakaway(rate: float) -> float:
        h = min(1e-3, 0.02 / rate)
        t, _, v = settle("lugre", LUGRE_1995, lambda t, x: rate * t, 2.0 / rate, h=h)
        return float(np.max(rate * t - np.gradient(v, h)))  # friction of the mass of 1 kg

    slow, middle, fast = breakaway(2.0), breakaway(10.0), breakaway(50.0)
    assert 1.5 > slow > middle > fast > 1.0


@pytest.mark.parametrize("name", ["lugre", "gms"])
def test_lag_in_sliding_widens_with_frequency(name: str) -> None:
    values = (
        LUGRE_1995
        if name == "lugre"
        else {
            **GMS,
            "coulomb": 1.0,
            "static": 1.5,
            "stribeck_velocity": 1e-3,
            "attraction": 300.0,
            "stiffness": [8e5, 3e5, 1e5],
        }
    )

    def area(frequency: float) -> float:
        steps = 20_000
        t = np.linspace(0.0, 3.0 / frequency, 3 * steps, endpoint=False)
        v = 1e-3 + 0.8e-3 * np.sin(2.0 * np.pi * frequency * t)
        torque = follow(name, values, v, t[1])
        return abs(float(np.trapezoid(torque[-steps:], v[-steps:])))

    areas = [area(f) for f in (1.0, 3.0, 9.0)]
    assert areas[0] < areas[1] < areas[2]


# --- passivity -----------------------------------------------------------------------------------------------------


def supplied(values: dict, v: np.ndarray, h: float) -> np.ndarray:
    """Energy put into the friction so far, from rest."""
    return np.cumsum(follow("lugre", values, v, h) * v * h)


def test_lugre_is_passive_when_its_condition_holds_and_not_otherwise() -> None:
    """F_v > σ₁·(F_s − F_c)/F_c (Barahanov and Ortega, IEEE Trans. Automatic Control 45(11), 2000)."""
    base = {"coulomb": 1.0, "static": 3.0, "stribeck_velocity": 0.01, "stribeck_exponent": 2.0}
    bristle = {**base, "bristle_stiffness": 1e4, "bristle_damping": 50.0}
    h = 1e-6
    load, burst = np.full(200_000, 1e-3), np.full(3, 20.0)
    cycle = np.concatenate([load, burst])  # load the bristles slowly, release them in a rush
    creating = supplied({**bristle, "viscous": 0.0}, np.tile(cycle, 3), h)
    ends = creating[cycle.size - 1 :: cycle.size]
    assert np.all(np.diff(ends) < 0.0)  # every cycle gives energy
    passive = {**bristle, "viscous": 50.0 * (3.0 - 1.0) / 1.0 * 1.01}
    kept = supplied(passive, np.tile(cycle, 3), h)
    assert np.all(np.diff(kept[cycle.size - 1 :: cycle.size]) > 0.0)
    rng = np.random.default_rng(2)
    for scale in (1e-3, 0.1, 5.0):
        v = np.repeat(scale * rng.normal(size=4000), 5)
        assert np.min(supplied(passive, v, 1e-4)) >= -1e-12


# --- surroundings --------------------------------------------------------------------------------------------------


def test_temperature_thins_and_position_waves() -> None:
    warm = LAWS["temperature_dependent"]
    p = warm.pack({"coulomb": 5.0, "viscous": 10.0, "coulomb_per_kelvin": 0.01, "viscous_decay": 0.03})
    assert warm.steady(2.0, ambient(1, temperature=35.0)[0], p) == pytest.approx(5.5 + 20.0 * math.exp(-0.3))
    wavy = LAWS["position_dependent"]
    q = wavy.pack({"coulomb": 5.0, "viscous": 0.0, "wavenumber": [2.0, 6.0], "cosine": [1.0, 0.0], "sine": [0.0, 0.5]})
    for x in (0.0, 0.3, -1.1):
        around = ambient(1, position=x)[0]
        assert wavy.steady(1.0, around, q) == pytest.approx(5.0 + math.cos(2.0 * x) + 0.5 * math.sin(6.0 * x))
        assert wavy.steady(-1.0, around, q) == -wavy.steady(1.0, around, q)


def test_seals_press_with_the_chambers_and_each_way_is_its_own() -> None:
    law = LAWS["pressure"]
    out = {
        "level_extending": 100.0,
        "growth_extending": 0.5,
        "pressure_difference_extending": 2e-5,
        "rod_pressure_extending": 1e-5,
    }
    back = {"level_retracting": 200.0, "pressure_difference_retracting": 3e-5, "viscous_retracting": 40.0}
    p = law.pack({**out, **back})
    around = ambient(1, pressure_head=6e6, pressure_rod=2e6)[0]
    assert law.steady(0.2, around, p) == pytest.approx(100.0 * math.exp(0.1) + 2e-5 * 4e6 + 1e-5 * 2e6)
    assert law.steady(-0.2, around, p) == pytest.approx(-(200.0 - 3e-5 * 4e6 + 40.0 * 0.2))


def test_seals_press_with_what_they_hold() -> None:
    law = LAWS["pressed_seals"]
    p = law.pack({"coulomb": 100.0, "viscous": 40.0, "head": 1e-5, "rod": 2e-5, "difference": 3e-5})
    for head, rod in ((6e6, 2e6), (2e6, 6e6)):
        level = 100.0 + 1e-5 * head + 2e-5 * rod + 3e-5 * 4e6
        around = ambient(1, pressure_head=head, pressure_rod=rod)[0]
        assert law.steady(0.2, around, p) == pytest.approx(level + 8.0)
        assert law.steady(-0.2, around, p) == pytest.approx(-level - 8.0)
    # Without the piston's it is law (2) with x₃ = ±h and x₄ = h + r.
    second = {f"{name}_{way}": 0.0 for name in ("level",) for way in ("extending", "retracting")}
    for way, sign in (("extending", 1.0), ("retracting", -1.0)):
        second |= {f"pressure_difference_{way}": sign * 1e-5, f"rod_pressure_{way}": 3e-5}
    around = ambient(1, pressure_head=6e6, pressure_rod=2e6)[0]
    chambers = law.pack({"coulomb": 0.0, "viscous": 0.0, "head": 1e-5, "rod": 2e-5, "difference": 0.0})
    for speed in (0.3, -0.3):
        own = LAWS["pressure"]
        assert law.steady(speed, around, chambers) == pytest.approx(own.steady(speed, around, own.pack(second)))


def test_a_gear_loses_more_driving_than_driven() -> None:
    law = LAWS["geared_load"]
    p = law.pack({"coulomb": 1.0, "load_driving": 0.2, "load_braking": 0.05, "viscous": 0.0})
    assert law.steady(1.0, ambient(1, load=10.0)[0], p) == pytest.approx(3.0)
    assert law.steady(-1.0, ambient(1, load=10.0)[0], p) == pytest.approx(-1.5)


def test_two_slopes_meet_at_the_threshold() -> None:
    law = LAWS["static_kinetic"]
    p = law.pack({"level": 2.0, "slope_below": 100.0, "slope_above": 5.0, "threshold_velocity": 0.02})
    around = ambient(1)[0]
    assert law.steady(0.02, around, p) == pytest.approx(4.0)
    assert law.steady(1.02, around, p) == pytest.approx(9.0)
    assert law.steady(0.01, around, p) == pytest.approx(3.0)


def test_breakaway_rises_with_the_time_at_rest() -> None:
    values = {
        "coulomb": 4.0,
        "static": 5.0,
        "static_rested": 9.0,
        "rise_time": 1.0,
        "stribeck_velocity": 1.0,
        "bristle_stiffness": 1e4,
        "viscous": 0.0,
    }

    def peak(wait: float) -> float:
        v = np.concatenate([np.zeros(round(wait * 1000)), np.full(2000, 0.05)])
        return float(np.max(follow("dwell_time", values, v, 1e-3)))

    for wait in (0.1, 1.0, 20.0):
        waited = wait + 0.012  # the deflection takes that long at 0.05 rad/s
        assert peak(wait) == pytest.approx(4.0 + 1.0 + 4.0 * waited / (waited + 1.0), rel=0.01)
    assert peak(20.0) > peak(1.0) + 1.0 > peak(0.1) + 2.0
