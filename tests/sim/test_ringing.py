"""A mass on a spring whose foot is moved, against its closed form."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from mjfriction.sim.lagging import Lagging
from mjfriction.sim.ringing import deflection, ringing

FREQUENCY, DAMPING = 2.0 * np.pi * 5.0, 0.05
INERTIA = 0.7  # kg·m²
SPRING, DAMPER = INERTIA * FREQUENCY**2, 2.0 * DAMPING * FREQUENCY * INERTIA


def aimed_at(aim: np.ndarray, step: float, finer: int = 1, hardening: float = 0.0) -> np.ndarray:
    # The mass alone, whose load would hold it at an aim (n,).
    link = Lagging(SPRING * aim, np.full(aim.size, INERTIA), np.zeros(aim.size), np.zeros(aim.size))
    return ringing(link, np.array([SPRING]), np.array([DAMPER]), step, finer, SPRING * hardening)[:, 0]


def lag(step: float, finer: int = 1) -> tuple[np.ndarray, np.ndarray]:
    # Its foot is moved at a constant speed of 1 from rest: s = t − (2ζ/ω)·(1 − …) − …, by the textbook.
    time = np.arange(0.0, 2.0, step * finer)
    damped = FREQUENCY * np.sqrt(1.0 - DAMPING**2)
    fading = np.exp(-DAMPING * FREQUENCY * time)
    wave = 2.0 * DAMPING / FREQUENCY * np.cos(damped * time) - (1.0 - 2.0 * DAMPING**2) / damped * np.sin(damped * time)
    exact = time - 2.0 * DAMPING / FREQUENCY + fading * wave
    return aimed_at(time, step, finer), exact


def test_it_follows_the_closed_form_with_second_order() -> None:
    errors = [np.max(np.abs(np.subtract(*lag(step)))) for step in (2e-3, 1e-3, 5e-4)]
    assert errors[0] < 0.01 / FREQUENCY
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.1)
    assert errors[1] / errors[2] == pytest.approx(4.0, rel=0.1)


def test_finer_steps_between_what_is_given_are_the_same_steps() -> None:
    coarse, fine = lag(1e-3, finer=8)[0], lag(1e-3)[0][::8]
    np.testing.assert_allclose(coarse, fine, atol=1e-12)


def test_a_stiff_one_is_where_its_load_holds_it() -> None:
    time = np.arange(0.0, 2.0, 1e-3)
    aim, stiff = np.sin(2.0 * np.pi * time), (2.0 * np.pi * 80.0) ** 2
    link = Lagging(stiff * aim, np.ones(time.size), np.zeros(time.size), np.zeros(time.size))
    place = ringing(link, np.array([stiff]), np.array([2.0 * np.sqrt(stiff)]), 1e-3)[:, 0]
    np.testing.assert_allclose(place[100:], aim[100:], atol=0.03)


@pytest.mark.parametrize("hardening", [0.0, 3e4])
def test_a_link_whose_load_changes_with_its_lag_is_as_an_independent_engine_has_it(hardening: float) -> None:
    """Its weight pulls it farther as it sags, its inertia changes with the pose, and its speed has a price."""

    def course(time: float | np.ndarray) -> np.ndarray:
        t = np.asarray(time)
        return np.array(
            [20.0 * np.sin(4.0 * t), 0.7 + 0.3 * np.sin(3.0 * t), -90.0 * np.cos(t), 0.8 + 0.5 * np.sin(2.0 * t)]
        )

    def rate(time: float, state: np.ndarray) -> list[float]:
        load, inertia, stiffness, damping = course(time)
        push = (SPRING + stiffness) * state[0] + hardening * state[0] ** 3 + (DAMPER + damping) * state[1]
        return [state[1], (load - push) / inertia]

    time = np.arange(0.0, 3.0, 1e-4)
    exact = solve_ivp(rate, (0.0, time[-1]), [0.0, 0.0], "Radau", time, rtol=1e-9, atol=1e-12).y[0]
    links, springs, dampers = Lagging(*course(time)), np.array([SPRING]), np.array([DAMPER])
    own = ringing(links, springs, dampers, 1e-4, 1, hardening)[:, 0]
    np.testing.assert_allclose(own, exact, atol=1e-4 * np.max(np.abs(exact)))
    for less in ("stiffness", "damping"):
        without = links._replace(**{less: np.zeros(time.size)})
        missed = ringing(without, springs, dampers, 1e-4, 1, hardening)[:, 0] - exact
        assert np.max(np.abs(missed)) > 0.01 * np.max(np.abs(exact))


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
        place = aimed_at(aim(time), step, hardening=HARDENING)
        errors.append(np.max(np.abs(place[:: round(4e-3 / step)] - exact)))
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.1)
    assert errors[1] / errors[2] == pytest.approx(4.0, rel=0.1)
    straight = aimed_at(aim(time), step)[:: round(4e-3 / step)]
    assert np.max(np.abs(straight - exact)) > 1000.0 * errors[2]


@pytest.mark.parametrize("hard", [[0.0, 0.0, 0.0], [20.0, 0.0, 900.0]])
def test_many_beside_each_other_are_moved_as_one_by_one(hard: list[float]) -> None:
    rng = np.random.default_rng(0)
    load, stiffness, damping = np.cumsum(rng.normal(size=(3, 500)), axis=1) * np.array([[1.0], [1.0], [0.01]])
    link = Lagging(load, 1.0 + 0.2 * np.sin(np.arange(500) / 40.0), stiffness, damping)
    springs, dampers = SPRING * np.array([1.0, 2.0, 0.5]), DAMPER * np.array([1.0, 3.0, 2.0])
    many = ringing(link, springs, dampers, 1e-3, 4, np.array(hard))
    for own, spring, damper, single in zip(many.T, springs, dampers, hard, strict=True):
        alone = ringing(link, np.array([spring]), np.array([damper]), 1e-3, 4, single)[:, 0]
        np.testing.assert_allclose(own, alone, rtol=1e-12, atol=1e-15)


@given(st.floats(-10.0, 10.0), st.floats(0.0, 1e6))
def test_where_it_is_held_the_springs_force_is_what_holds_it(aim: float, hardening: float) -> None:
    held = float(deflection(np.array([aim]), hardening)[0])
    assert held + hardening * held**3 == pytest.approx(aim, rel=1e-9, abs=1e-12)
