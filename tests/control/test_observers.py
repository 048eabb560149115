"""Observers of friction: their errors die away as their equations say, and not where these say they do not."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import expm

from mjfriction.control.bristle_observer import BristleObserver
from mjfriction.control.chattering import chattering
from mjfriction.control.disturbance import DisturbanceObserver
from mjfriction.control.friedland import FriedlandMentzelopoulou, FriedlandPark, Tafazoli
from mjfriction.control.observer import Observer, estimate_along
from mjfriction.control.variable_structure import VariableStructure
from mjfriction.errors import ControlError
from mjfriction.laws.friction import Friction, Level, friction
from tests.control.rubbing_mass import Ran, run

MASS, STEP = 2.0, 1e-3
LUGRE = {
    "coulomb": 8.0,
    "static": 10.0,
    "stribeck_velocity": 0.02,
    "stribeck_exponent": 2.0,
    "viscous": 3.0,
    "bristle_stiffness": 2e4,
    "bristle_damping": 100.0,
}


def coulomb(level: float) -> Friction:
    return friction("coulomb", {"coulomb": level})


def lugre() -> Friction:
    return friction("lugre", LUGRE)


def loaded() -> Friction:
    return friction("lugre", LUGRE, level=Level(per_load=0.05))


@pytest.fixture(scope="module")
def swung() -> Ran:
    time = np.arange(0.0, 4.0, STEP)
    return run(MASS, lugre(), 30.0 * np.sin(2.0 * np.pi * 0.5 * time), STEP)


OBSERVERS: dict[str, Observer] = {
    "park": FriedlandPark(MASS, gain=60.0),
    "mentzelopoulou": FriedlandMentzelopoulou(MASS, gain=60.0, velocity_gain=200.0),
    "tafazoli": Tafazoli(MASS, gain=60.0, velocity_gain=200.0),
    "variable structure": VariableStructure.with_rate(MASS, 60.0, 2.0, 1e-2),
    "kalman": DisturbanceObserver.kalman(MASS, STEP, position_noise=1e-6, force_walk=1e-3),
    "bandwidth": DisturbanceObserver.with_bandwidth(MASS, STEP, 15.0),
    "bristle": BristleObserver(MASS, lugre(), velocity_gain=50.0, bristle_gain=0.05),
}


@pytest.mark.parametrize("name", OBSERVERS)
def test_friction_of_a_swinging_mass_is_followed(swung: Ran, name: str) -> None:
    found, speed = estimate_along(OBSERVERS[name], STEP, swung.position, swung.force, swung.velocity)
    sliding = (np.arange(swung.force.size) > 1000) & (np.abs(swung.velocity) > 0.5 * np.max(np.abs(swung.velocity)))
    error = np.sqrt(np.mean(np.square(found - swung.friction)[sliding]))
    assert error < 0.12 * np.sqrt(np.mean(np.square(swung.friction[sliding])))
    assert np.max(np.abs(speed - swung.velocity)[sliding]) < 0.05 * np.max(np.abs(swung.velocity))


@pytest.mark.parametrize("exponent", [0.5, 1.0, 2.0])
def test_the_level_is_learnt_at_the_rate_that_the_equation_says(exponent: float) -> None:
    level, v, gain = 5.0, 0.3, 4.0
    observer = FriedlandPark(MASS, gain=gain, exponent=exponent)
    time = STEP * np.arange(2000)
    at = np.full(time.size, v)
    found, _ = estimate_along(observer, STEP, np.cumsum(at) * STEP, np.full(time.size, level), at)
    rate = gain * exponent * v ** (exponent - 1.0)
    np.testing.assert_allclose(found, level * (1.0 - np.exp(-rate * time)), rtol=1e-9, atol=1e-12)


def test_a_filtered_derivative_lags_where_the_net_force_does_not() -> None:
    # Speeding up at a steady rate a: the derivative through k_v is late by a/k_v, the other's is not.
    push, level = 9.0, 3.0
    ran = run(MASS, coulomb(level), np.full(3000, push), STEP, finer=1)
    gain = 50.0
    late, told = (
        ran.velocity[-1] - estimate_along(kind(MASS, 20.0, gain), STEP, ran.position, ran.force)[1][-1]
        for kind in (Tafazoli, FriedlandMentzelopoulou)
    )
    expected = (push - level) / MASS / gain
    assert late == pytest.approx(expected, rel=0.1)
    assert abs(told) < 0.1 * expected


def errors_of_sliding(observer: VariableStructure, level: float, steps: int, step: float) -> np.ndarray:
    # At rest in truth, with a force that friction holds: what is left to learn is friction alone.
    state, out = observer.start(0.0), np.empty(steps)
    for i in range(steps):
        state, out[i], _ = observer.step(state, 0.0, 0.0, level, step)
    return out - level


def test_the_variable_structure_observer_errs_as_its_two_equations_say() -> None:
    level, rate, step = 6.0, 40.0, 1e-5
    observer = VariableStructure.with_rate(MASS, rate, 5.0, 1e-3)
    errors = errors_of_sliding(observer, level, 20000, step)
    # e' = A e of (velocity, friction), from (0, −level).
    system = np.array([[observer.velocity_gain, -1.0 / MASS], [observer.friction_gain, 0.0]])
    expected = np.array([(expm(system * step * (i + 1)) @ [0.0, -level])[1] for i in range(0, 20000, 500)])
    np.testing.assert_allclose(errors[::500], expected, atol=0.02 * level)


def test_sharp_switching_chatters_and_smooth_switching_does_not(swung: Ran) -> None:
    sharp, smooth = (
        estimate_along(VariableStructure.with_rate(MASS, 60.0, 2.0, width), STEP, swung.position, swung.force)[0]
        for width in (0.0, 1e-2)
    )
    assert chattering(sharp, 1.0 / STEP, 100.0) > 20.0 * chattering(smooth, 1.0 / STEP, 100.0)


def test_chattering_measures_what_lies_above_a_frequency() -> None:
    time = np.arange(0.0, 20.0, 1e-3)
    slow, fast = 5.0 * np.sin(2.0 * np.pi * 2.0 * time), 0.3 * np.sin(2.0 * np.pi * 150.0 * time)
    assert chattering(slow + fast, 1000.0, 50.0) == pytest.approx(0.3 / np.sqrt(2.0), rel=0.02)
    with pytest.raises(ControlError, match="stay below 500 Hz"):
        chattering(slow, 1000.0, 600.0)


@pytest.mark.parametrize("shape", ["constant", "ramp"])
def test_a_second_order_walk_follows_constant_and_rising_friction_without_error(shape: str) -> None:
    steps = 8000
    time = STEP * np.arange(steps)
    drag = np.full(steps, 4.0) if shape == "constant" else 2.0 * time
    force = 5.0 + 0.0 * time
    v = np.concatenate([[0.0], np.cumsum((force - drag) / MASS * STEP)[:-1]])
    x = np.concatenate([[0.0], np.cumsum(v * STEP)[:-1]])
    for observer in (OBSERVERS["kalman"], OBSERVERS["bandwidth"]):
        found, speed = estimate_along(observer, STEP, x, force)
        assert found[-2] == pytest.approx(drag[-1], abs=1e-6)
        assert speed[-2] == pytest.approx(v[-1], abs=1e-7)


def test_the_kalman_gain_is_where_the_filter_settles_by_itself() -> None:
    noise, walk, viscous = 2e-6, 5e-3, 1.5
    observer = DisturbanceObserver.kalman(MASS, STEP, position_noise=noise, force_walk=walk, viscous=viscous)
    forward = np.eye(4)
    forward[0, 0], forward[0, 2] = 1.0 - viscous * STEP / MASS, -STEP / MASS
    forward[1, 0] = forward[2, 3] = STEP
    seen = np.array([[0.0, 1.0, 0.0, 0.0]])
    driven = np.diag([0.0, 0.0, 0.0, walk**2 / STEP**2])
    spread = np.diag([1e-2, 1e-8, 10.0, 10.0])
    for _ in range(20000):
        gain = forward @ spread @ seen.T / (seen @ spread @ seen.T + noise**2)
        spread = (forward - gain @ seen) @ spread @ forward.T + driven
        spread = 0.5 * (spread + spread.T)
    np.testing.assert_allclose(observer.gains, gain[:, 0], rtol=1e-4)


def test_all_errors_of_a_bandwidth_die_away_at_its_rate() -> None:
    # A constant friction switched on: four equal poles leave e^(−ωt)·(a cubic in t), however fast or slow.
    for bandwidth in (2.0, 20.0):
        observer = DisturbanceObserver.with_bandwidth(MASS, STEP, bandwidth)
        rate = 2.0 * np.pi * bandwidth
        steps = round(12.0 / rate / STEP)
        found, _ = estimate_along(observer, STEP, np.zeros(steps), np.full(steps, 5.0))
        time = STEP * np.arange(steps)
        shape = np.column_stack([np.exp(-rate * time) * (rate * time) ** k for k in range(4)])
        left = 5.0 - found
        told = shape @ np.linalg.lstsq(shape, left, rcond=None)[0]
        assert np.max(np.abs(told - left)) < 0.02 * np.max(np.abs(left))
        assert abs(left[-1]) < 0.02 * 5.0


def test_the_bristle_observer_finds_a_deflection_that_it_was_not_told() -> None:
    # Held before slip by a force: the bristle is bent, and an observer that begins unbent must learn it.
    force = np.full(4000, 6.0)
    ran = run(MASS, lugre(), force, STEP)
    learnt, held = (
        estimate_along(
            BristleObserver(MASS, lugre(), 50.0, gain), STEP, ran.position[1000:], force[1000:], ran.velocity[1000:]
        )[0]
        for gain in (0.05, 1e-9)
    )
    assert learnt[-1] == pytest.approx(6.0, rel=1e-3)
    assert abs(held[-1] - 6.0) > 1.0, "without the correction the deflection is never found"


@pytest.mark.parametrize("speed", [0.05, 0.5, 3.0])
def test_a_bristle_told_wrong_is_mended_at_every_speed(speed: float) -> None:
    # At a held speed the force is the friction: half more than the law says.  The correction goes the right way.
    held, force = np.full(6000, speed), np.full(6000, 14.0)
    place = np.cumsum(held) * STEP
    errors = [
        abs(estimate_along(BristleObserver(MASS, lugre(), 50.0, gain), STEP, place, force, held)[0][-1] - 14.0)
        for gain in (1e-9, 2e-3)
    ]
    assert errors[1] < errors[0]


@settings(max_examples=20, deadline=None)
@given(name=st.sampled_from(sorted(OBSERVERS)), seed=st.integers(0, 1000))
def test_motion_mirrored_is_friction_mirrored(name: str, seed: int) -> None:
    rng = np.random.default_rng(seed)
    force = np.cumsum(rng.standard_normal(300))
    position = 1e-3 * np.cumsum(np.cumsum(rng.standard_normal(300))) * STEP
    velocity = np.gradient(position, STEP)
    one = estimate_along(OBSERVERS[name], STEP, position, force, velocity)
    other = estimate_along(OBSERVERS[name], STEP, -position, -force, -velocity)
    for a, b in zip(one, other, strict=True):
        np.testing.assert_allclose(a, -b, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("name", OBSERVERS)
def test_along_a_log_is_step_by_step_to_the_bit(swung: Ran, name: str) -> None:
    observer = OBSERVERS[name]
    state = observer.start(float(swung.position[0]), float(swung.velocity[0]))
    before, stepped = state.copy(), []
    for i in range(200):
        state, force, speed = observer.step(
            state, float(swung.position[i]), float(swung.velocity[i]), float(swung.force[i]), STEP
        )
        stepped.append((force, speed))
    along = estimate_along(observer, STEP, swung.position[:200], swung.force[:200], swung.velocity[:200])
    assert np.array_equal(np.array(stepped).T, np.array(along))
    again = observer.start(float(swung.position[0]), float(swung.velocity[0]))
    assert np.array_equal(before, again, equal_nan=True)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: FriedlandPark(0.0, 1.0), "mass = 0; it must be above 0"),
        (lambda: FriedlandPark(1.0, -1.0), "gain = -1; it must be above 0"),
        (lambda: FriedlandPark(1.0, float("nan")), "gain = nan; a finite number"),
        (lambda: Tafazoli(1.0, 1.0, 0.0), "velocity_gain = 0; it must be above 0"),
        (lambda: VariableStructure(1.0, 1.0, 2.0, 3.0), "velocity_gain = 2; it must be below 0"),
        (lambda: VariableStructure(1.0, 1.0, -2.0, -3.0), "friction_gain = -3; it must be above 0"),
        (
            lambda: VariableStructure(1.0, 2.0, -2.0, 3.0, 1e-4).check_step(1e-3),
            "0.001 s its errors do not die away",
        ),
        (
            lambda: DisturbanceObserver(1.0, 0.0, 1e-3, (0.0, 0.0, 0.0, 0.0)),
            "do not die away but change by 1 a step",
        ),
        (lambda: DisturbanceObserver.with_bandwidth(1.0, 1e-3, 5.0).check_step(2e-3), "steps of 0.001 s, not 0.002 s"),
        (
            lambda: DisturbanceObserver.kalman(1.0, 1e-3, position_noise=0.0, force_walk=1.0),
            "position_noise above 0, not 0",
        ),
        (lambda: DisturbanceObserver.with_bandwidth(1.0, 1e-3, 1e-2), "too slow for steps of 0.001 s.*at least 0.1 Hz"),
        (lambda: DisturbanceObserver.with_bandwidth(0.0, 1e-3, 1.0), "mass above 0, not 0"),
        (lambda: BristleObserver(1.0, coulomb(1.0), 1.0, 1.0), "one bristle.*not 'coulomb'"),
        (lambda: BristleObserver(1.0, loaded(), 1.0, 1.0), "neither load, place nor temperature"),
        (lambda: BristleObserver(1.0, lugre(), 1.0, 1e4).check_step(1e-3), "its errors do not die away"),
        (lambda: estimate_along(OBSERVERS["kalman"], STEP, np.zeros(3), np.zeros(4)), "must be alike"),
        (lambda: estimate_along(OBSERVERS["kalman"], STEP, np.array([0.0, np.nan]), np.zeros(2)), "finite numbers"),
        (lambda: estimate_along(FriedlandPark(1.0, 1.0), 1e-3, np.zeros(3), np.zeros(3)), "needs a measured velocity"),
    ],
)
def test_what_cannot_converge_is_refused_by_name(make: Any, message: str) -> None:
    with pytest.raises(ControlError, match=message):
        make()


def test_gains_that_the_condition_forbids_do_run_away() -> None:
    # Built past the check: with L₁ > 0 the errors grow, which is what the condition is there for.
    good = VariableStructure(MASS, 5.0, -64.0, 3200.0, 1e-2)
    wrong = object.__new__(VariableStructure)
    for name, value in vars(good).items():
        object.__setattr__(wrong, name, 64.0 if name == "velocity_gain" else value)
    settled, lost = (errors_of_sliding(observer, 6.0, 2000, STEP) for observer in (good, wrong))
    assert abs(settled[-1]) < 0.05
    assert np.max(np.abs(lost[-500:])) > 6.0
