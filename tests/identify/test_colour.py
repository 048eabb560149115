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
    gap = SimpleNamespace(clear=seen[:, None], noise_floor=np.array([floor]), chain=SimpleNamespace(step=STEP))
    return coloured_share(gap, 0, residual)


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
