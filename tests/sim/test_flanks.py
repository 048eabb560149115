"""A mass between springy flanks, against free fall, an independent integrator, and a mass on a spring."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from mjfriction.sim.flanks import between_flanks
from mjfriction.sim.lagging import Lagging
from mjfriction.sim.ringing import ringing

FREQUENCY, DAMPING, HALF = 2.0 * np.pi * 12.0, 0.1, 0.01
INERTIA = 0.3  # kg·m²
SPRING, DAMPER = INERTIA * FREQUENCY**2, 2.0 * DAMPING * FREQUENCY * INERTIA


def alone(aim: np.ndarray) -> Lagging:
    """Return a mass whose load would hold its spring at an aim (n,)."""
    return Lagging(SPRING * aim, np.full(aim.size, INERTIA), np.zeros(aim.size), np.zeros(aim.size))


def between(link: Lagging, half: float, step: float, finer: int = 1, hardening: float = 0.0) -> np.ndarray:
    halves, springs, dampers = (np.array([own]) for own in (half, SPRING, DAMPER))
    return between_flanks(link, halves, springs, dampers, step, finer, SPRING * hardening)[:, 0]


def aims(time: np.ndarray) -> np.ndarray:
    return np.asarray(0.004 * np.sin(7.0 * time) + 0.003 * np.sin(19.0 * time))


def followed(step: float, finer: int = 1, hardening: float = 0.0) -> np.ndarray:
    return between(alone(aims(np.arange(0.0, 1.0, step * finer))), HALF, step, finer, hardening)


@pytest.mark.parametrize("hardening", [0.0, 4e4])
def test_it_is_where_an_independent_integrator_has_it(hardening: float) -> None:
    def slope(t: float, state: np.ndarray) -> list[float]:
        place, speed = state
        beyond = place - np.clip(place, -HALF, HALF)
        push = FREQUENCY**2 * (beyond + hardening * beyond**3) + 2.0 * DAMPING * FREQUENCY * speed * (beyond != 0.0)
        return [speed, FREQUENCY**2 * aims(np.array(t)) - max(push * np.sign(beyond), 0.0) * np.sign(beyond)]

    step, time = 5e-5, np.arange(0.0, 1.0, 1e-3)
    exact = solve_ivp(slope, (0.0, 1.0), [0.0, 0.0], t_eval=time, method="Radau", rtol=1e-8, atol=1e-12, max_step=2e-4)
    own = followed(step, hardening=hardening)[: 20 * time.size : 20]
    assert np.max(np.abs(exact.y[0])) > 1.2 * HALF
    np.testing.assert_allclose(own, exact.y[0], atol=0.02 * HALF)


def test_within_its_flanks_it_falls_freely() -> None:
    step, pull = 1e-4, 8.0
    time = np.arange(0.0, 0.04, step)
    place = between(alone(np.where(time < 0.5 * step, 0.0, pull / FREQUENCY**2)), HALF, step)
    assert np.max(place) < HALF
    np.testing.assert_allclose(place, 0.5 * pull * time**2, atol=1e-4 * HALF + pull * step * time[-1])


def test_without_play_it_is_a_mass_on_a_spring_as_long_as_the_flanks_need_not_pull() -> None:
    """Always pressed to one side, it never leaves that flank."""
    time = np.arange(0.0, 2.0, 1e-3)
    aim = 0.01 + 0.003 * np.sin(9.0 * time)
    sprung = ringing(alone(aim), np.array([SPRING]), np.array([DAMPER]), 1e-3)[:, 0]
    for half in (0.0, HALF):
        np.testing.assert_allclose(between(alone(aim), half, 1e-3), half + sprung, atol=1e-12)


def test_finer_steps_between_what_is_given_are_the_same_steps() -> None:
    step, finer = 1e-3, 4
    coarse = np.arange(0.0, 1.0, step * finer)
    fine = np.arange(0.0, coarse[-1] + 0.5 * step, step)
    expected = between(alone(np.interp(fine, coarse, aims(coarse))), HALF, step)[::finer]
    assert followed(step, finer)[: expected.size] == pytest.approx(expected, abs=1e-12)


def test_a_link_whose_load_changes_with_its_lag_is_where_an_independent_integrator_has_it() -> None:
    """Its weight pulls it on as it falls, through the drag of its joint."""

    def course(time: float | np.ndarray) -> np.ndarray:
        t = np.asarray(time)
        return np.array([6.0 * np.sin(3.0 * t), 0.3 + 0.1 * np.sin(t), -150.0 + 0.0 * t, 1.5 + 0.0 * t])

    def slope(t: float, state: np.ndarray) -> list[float]:
        place, speed = state
        load, inertia, stiffness, damping = course(t)
        beyond = place - np.clip(place, -HALF, HALF)
        push = (SPRING * beyond + DAMPER * speed * (beyond != 0.0)) * np.sign(beyond)
        pulled = load - stiffness * place - damping * speed - max(push, 0.0) * np.sign(beyond)
        return [speed, pulled / inertia]

    step, time = 5e-5, np.arange(0.0, 2.0, 1e-3)
    exact = solve_ivp(slope, (0.0, 2.0), [0.0, 0.0], t_eval=time, method="Radau", rtol=1e-8, atol=1e-12, max_step=2e-4)
    fine = Lagging(*course(np.arange(0.0, 2.0, step)))
    np.testing.assert_allclose(between(fine, HALF, step)[:: round(1e-3 / step)], exact.y[0], atol=0.05 * HALF)
    for less in ("stiffness", "damping"):
        without = fine._replace(**{less: np.zeros(fine.load.size)})
        assert np.max(np.abs(between(without, HALF, step)[:: round(1e-3 / step)] - exact.y[0])) > 0.2 * HALF
