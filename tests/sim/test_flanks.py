"""A mass between springy flanks, against free fall, an independent integrator, and a mass on a spring."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from mjfriction.sim.flanks import between_flanks
from mjfriction.sim.ringing import ringing

FREQUENCY, DAMPING, HALF = 2.0 * np.pi * 12.0, 0.1, 0.01


def aims(time: np.ndarray) -> np.ndarray:
    return np.asarray(0.004 * np.sin(7.0 * time) + 0.003 * np.sin(19.0 * time))


def followed(step: float, finer: int = 1, hardening: float = 0.0) -> np.ndarray:
    aim = aims(np.arange(0.0, 1.0, step * finer))[:, None]
    return between_flanks(aim, np.full_like(aim, FREQUENCY), np.array([HALF]), DAMPING, step, finer, hardening)[:, 0]


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
    aim = np.where(time < 0.5 * step, 0.0, pull / FREQUENCY**2)[:, None]
    place = between_flanks(aim, np.full_like(aim, FREQUENCY), np.array([HALF]), DAMPING, step)[:, 0]
    assert np.max(place) < HALF
    np.testing.assert_allclose(place, 0.5 * pull * time**2, atol=1e-4 * HALF + pull * step * time[-1])


def test_without_play_it_is_a_mass_on_a_spring_as_long_as_the_flanks_need_not_pull() -> None:
    """Always pressed to one side, it never leaves that flank."""
    time = np.arange(0.0, 2.0, 1e-3)
    aim = 0.01 + 0.003 * np.sin(9.0 * time)
    sprung = ringing(aim, np.full(time.size, FREQUENCY), DAMPING, 1e-3)
    for half in (0.0, HALF):
        own = between_flanks(aim[:, None], np.full((time.size, 1), FREQUENCY), np.array([half]), DAMPING, 1e-3)[:, 0]
        np.testing.assert_allclose(own, half + sprung, atol=1e-12)


def test_finer_steps_between_what_is_given_are_the_same_steps() -> None:
    step, finer = 1e-3, 4
    coarse = np.arange(0.0, 1.0, step * finer)
    fine = np.arange(0.0, coarse[-1] + 0.5 * step, step)
    linear = np.interp(fine, coarse, aims(coarse))[:, None]
    expected = between_flanks(linear, np.full_like(linear, FREQUENCY), np.array([HALF]), DAMPING, step)[::finer, 0]
    assert followed(step, finer)[: expected.size] == pytest.approx(expected, abs=1e-12)
