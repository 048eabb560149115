"""What stands above the noise in a spectrum: courses do, white noise and that of differentiation do not."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.signal import lfilter

from mjfriction.identify.colour import coloured_share

ROWS = 1500
STEP = 0.02  # s


def share(residual: np.ndarray, floor: float = 1.0, clear: np.ndarray | None = None) -> float:
    seen = np.ones(ROWS, dtype=bool) if clear is None else clear
    return share_of_first(residual[:, None], np.array([floor]), seen[:, None])


def share_of_first(residuals: np.ndarray, floors: np.ndarray, clear: np.ndarray | None = None) -> float:
    seen = np.ones(residuals.shape, dtype=bool) if clear is None else clear
    joints = tuple(range(residuals.shape[1]))
    gap = SimpleNamespace(clear=seen, noise_floor=floors, chain=SimpleNamespace(step=STEP), examined=joints)
    return coloured_share(gap, 0, residuals)  # type: ignore[arg-type]


@settings(deadline=None, max_examples=60)
@given(st.integers(0, 10**6))
def test_noise_of_any_seed_is_no_course(seed: int) -> None:
    rng = np.random.default_rng(seed)
    white = rng.standard_normal(ROWS)
    assert share(white) < 0.1
    assert share(np.diff(white, prepend=0.0), floor=0.0) < 0.1


def low_passed(corner: float, seed: int) -> np.ndarray:
    """Return white noise behind a first-order low-pass of a corner frequency (Hz)."""
    keeps = np.exp(-2.0 * np.pi * corner * STEP)
    return np.asarray(lfilter([1.0 - keeps], [1.0, -keeps], np.random.default_rng(seed).standard_normal(ROWS)))


@settings(deadline=None, max_examples=30)
@given(st.integers(0, 10**6), st.floats(9.0, 40.0))
def test_noise_that_a_drive_low_passed_is_no_course(seed: int, corner: float) -> None:
    # The sensor's noise as it is seen between samples, far above the corner, tells next to nothing of it.
    assert share(low_passed(corner, seed), floor=0.0) < 0.25


def test_noise_that_wanders_is_a_course() -> None:
    assert share(low_passed(0.3, 1), floor=0.0) > 0.8
    wander, noise = low_passed(0.3, 2), low_passed(12.0, 3)
    assert share(1.5 * wander / np.std(wander) + noise / np.std(noise), floor=0.0) > 0.5


@pytest.mark.parametrize("size", [1.0, 2.0])
@pytest.mark.parametrize("period", [6.0, 40.0, 300.0])
def test_the_share_of_a_hum_in_noise_is_its_power(size: float, period: float) -> None:
    rng = np.random.default_rng(3)
    hum = size * np.sqrt(2.0) * np.sin(2.0 * np.pi * np.arange(ROWS) / period)
    expected = size**2 / (1.0 + size**2)
    assert share(hum + rng.standard_normal(ROWS)) == pytest.approx(expected, abs=0.08)


def test_rows_that_are_in_doubt_are_left_out() -> None:
    rng = np.random.default_rng(4)
    clear = rng.random(ROWS) < 0.6
    residual = rng.standard_normal(ROWS) + np.where(clear, 0.0, 50.0)
    assert share(residual, clear=clear) < 0.1
    assert share(residual, clear=np.zeros(ROWS, dtype=bool)) == 0.0


def test_what_is_within_the_sensors_noise_is_none() -> None:
    course = np.sin(2.0 * np.pi * np.arange(ROWS) / 50.0)
    assert share(course, floor=0.1) > 0.9
    assert share(course, floor=20.0) == 0.0


SCALES = np.array([1.0, 0.02, 30.0, 4.0, 0.5, 7.0])  # efforts of different joints, and their sensors' noise


def slow_noise(times: float, joints: int) -> np.ndarray:
    """Return noise of joints that is below some 2 Hz, and ``times`` as large as what their sensors seem to have."""
    noise = np.column_stack([low_passed(2.0, 10 + joint) for joint in range(joints)])
    return np.asarray(times * noise / np.std(noise, axis=0) * SCALES[:joints])


def test_noise_of_all_joints_alike_has_that_colour() -> None:
    noise = slow_noise(2.4, 6)
    assert share_of_first(noise, SCALES) < 0.3
    # Of one joint among quiet ones, or of too few to compare, the same is a course that wanders.
    alone = noise.copy()
    alone[:, 1:] = np.random.default_rng(5).standard_normal((ROWS, 5)) * SCALES[1:]
    assert share_of_first(alone, SCALES) > 0.5
    assert share_of_first(noise[:, :3], SCALES[:3]) > 0.5


def test_a_hum_stands_out_from_noise_that_all_joints_have() -> None:
    noise = slow_noise(2.4, 6)
    noise[:, 0] += 5.0 * np.sin(2.0 * np.pi * np.arange(ROWS) / 40.0)
    assert share_of_first(noise, SCALES) > 0.5


def test_what_is_far_above_the_sensors_noise_is_none_of_it_though_all_joints_have_it() -> None:
    assert share_of_first(slow_noise(8.0, 6), SCALES) > 0.5
