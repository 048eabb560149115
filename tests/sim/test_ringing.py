"""A mass on a spring whose foot is moved, against its closed form."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from mjfriction.sim.ringing import deflection, ringing

FREQUENCY, DAMPING = 2.0 * np.pi * 5.0, 0.05


def lag(step: float, finer: int = 1) -> tuple[np.ndarray, np.ndarray]:
    # Its foot is moved at a constant speed of 1 from rest: s = t − (2ζ/ω)·(1 − …) − …, by the textbook.
    time = np.arange(0.0, 2.0, step * finer)
    damped = FREQUENCY * np.sqrt(1.0 - DAMPING**2)
    fading = np.exp(-DAMPING * FREQUENCY * time)
    wave = 2.0 * DAMPING / FREQUENCY * np.cos(damped * time) - (1.0 - 2.0 * DAMPING**2) / damped * np.sin(damped * time)
    exact = time - 2.0 * DAMPING / FREQUENCY + fading * wave
    return ringing(time, np.full(time.size, FREQUENCY), DAMPING, step, finer), exact


def test_it_follows_the_closed_form_with_second_order() -> None:
    errors = [np.max(np.abs(np.subtract(*lag(step)))) for step in (2e-3, 1e-3, 5e-4)]
    assert errors[0] < 0.01 / FREQUENCY
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.1)
    assert errors[1] / errors[2] == pytest.approx(4.0, rel=0.1)


def test_finer_steps_between_what_is_given_are_the_same_steps() -> None:
    coarse, fine = lag(1e-3, finer=8)[0], lag(1e-3)[0][::8]
    np.testing.assert_allclose(coarse, fine, atol=1e-12)


def test_a_stiff_one_is_where_it_aims() -> None:
    time = np.arange(0.0, 2.0, 1e-3)
    aim = np.sin(2.0 * np.pi * time)
    place = ringing(aim, np.full(time.size, 2.0 * np.pi * 80.0), 1.0, 1e-3)
    np.testing.assert_allclose(place[100:], aim[100:], atol=0.03)


def test_many_beside_each_other_are_moved_as_one_by_one() -> None:
    rng = np.random.default_rng(0)
    aims = 1e-2 * np.cumsum(rng.normal(size=(500, 5)), axis=0)
    frequencies = 2.0 * np.pi * np.abs(8.0 + rng.normal(size=aims.shape))
    many = ringing(aims, frequencies, DAMPING, 1e-3, 4)
    for own, aim, frequency in zip(many.T, aims.T, frequencies.T, strict=True):
        np.testing.assert_allclose(own, ringing(aim, frequency, DAMPING, 1e-3, 4), rtol=1e-12, atol=1e-15)


HARDENING = 40.0  # per rad²


def test_a_spring_that_hardens_is_as_an_independent_engine_has_it_with_second_order() -> None:
    def aim(time: float | np.ndarray) -> np.ndarray:
        return np.asarray(0.3 * (1.0 - np.cos(7.0 * time)) + 0.1 * np.sin(23.0 * time))

    def rate(time: float, state: np.ndarray) -> list[float]:
        pull = float(aim(time)) - state[0] - HARDENING * state[0] ** 3
        return [state[1], FREQUENCY**2 * pull - 2.0 * DAMPING * FREQUENCY * state[1]]

    asked = np.arange(0.0, 1.5, 4e-3)
    exact = solve_ivp(rate, (0.0, asked[-1]), [0.0, 0.0], "Radau", asked, rtol=1e-10, atol=1e-12).y[0]
    errors = []
    for step in (1e-3, 5e-4, 2.5e-4):
        time = np.arange(0.0, asked[-1] + 0.5 * step, step)
        place = ringing(aim(time), np.full(time.size, FREQUENCY), DAMPING, step, hardening=HARDENING)
        errors.append(np.max(np.abs(place[:: round(4e-3 / step)] - exact)))
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.1)
    assert errors[1] / errors[2] == pytest.approx(4.0, rel=0.1)
    straight = ringing(aim(time), np.full(time.size, FREQUENCY), DAMPING, step)[:: round(4e-3 / step)]
    assert np.max(np.abs(straight - exact)) > 1000.0 * errors[2]


def test_masses_on_other_springs_are_moved_as_one_by_one() -> None:
    time = np.arange(0.0, 1.0, 1e-3)
    aims, hard = np.outer(np.sin(9.0 * time), [0.1, 0.4, 0.4]), np.array([20.0, 0.0, 20.0])
    frequency = np.full(aims.shape, FREQUENCY)
    many = ringing(aims, frequency, DAMPING, 1e-3, 4, hard)
    for own, aim, single in zip(many.T, aims.T, hard, strict=True):
        np.testing.assert_allclose(own, ringing(aim, frequency[:, 0], DAMPING, 1e-3, 4, single), rtol=1e-12, atol=1e-15)


@given(st.floats(-10.0, 10.0), st.floats(0.0, 1e6))
def test_where_it_is_held_the_springs_force_is_what_holds_it(aim: float, hardening: float) -> None:
    held = float(deflection(np.array([aim]), hardening)[0])
    assert held + hardening * held**3 == pytest.approx(aim, rel=1e-9, abs=1e-12)
