"""What hardly shows beside what is left is no finding: how much that is."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from mjfriction.diagnose.untold import shows

ROWS = 4000


def gap() -> Any:
    return SimpleNamespace(examined=(0, 1), rms=lambda values, joint: float(np.sqrt(np.mean(np.square(values)))))


def left(*mean_squares: float) -> np.ndarray:
    return np.sqrt(np.array(mean_squares)) * np.ones((ROWS, 1))


@pytest.mark.parametrize(
    ("taken", "by_others", "unexplained", "seen"),
    [
        (0.15, 0.0, 0.0, True),  # little, but nothing larger is beside it
        (0.05, 0.0, 0.0, False),  # too little
        (0.15, 10.0, 0.0, False),  # as much as a large cause leaves whose form is not quite the one fitted
        (0.25, 1000.0, 0.0, True),  # enough, whatever others take
        (0.25, 0.0, 0.5, False),  # less than what none explains
    ],
)
def test_what_is_taken_off_what_is_left_decides(taken: float, by_others: float, unexplained: float, seen: bool) -> None:
    after = left(1.0, 1.0)
    before = left(1.0 + taken, 1.0)
    bare = left(1.0 + taken + by_others, 1.0)
    assert shows(gap(), before, after, {0: unexplained}, bare, {}) is seen


def test_one_joint_is_enough() -> None:
    after, before = left(1.0, 1.0), left(1.0, 1.5)
    assert shows(gap(), before, after, {0: 1.0}, before, {})


def test_beside_a_bristle_more_is_asked_for_on_its_own_joint() -> None:
    after, before = left(1.0, 1.0), left(1.4, 1.0)
    bristle = left(201.0, 1.0)  # what no bristle is drawn right to half a percent: as much as the noise
    assert shows(gap(), before, after, {}, bristle, {})
    assert not shows(gap(), before, after, {}, bristle, {0: bristle})
    assert shows(gap(), before, after, {}, bristle, {1: bristle})
    assert shows(gap(), left(2.2, 1.0), after, {}, bristle, {0: bristle})
