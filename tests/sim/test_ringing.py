"""A mass on a spring whose foot is moved, against its closed form."""

from __future__ import annotations

import numpy as np
import pytest

from mjfriction.sim.ringing import ringing

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
