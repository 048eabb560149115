"""How quickly a log moves, among drives that tremble."""

from __future__ import annotations

import numpy as np
import pytest

from mjfriction.record.motion_frequency import motion_frequency, quickest_motion

RATE = 500.0


def swing(seconds: float, reach: float, tremble: float) -> np.ndarray:
    """Return a swing at 0.5 Hz there and back, with a tremble at 97 Hz, in counts of an encoder."""
    time = np.arange(seconds * RATE) / RATE
    course = reach * (1.0 - np.cos(np.pi * time)) + tremble * np.sin(2.0 * np.pi * 97.0 * time)
    return np.round(course / 2e-4) * 2e-4


def test_it_is_told_where_a_joint_travels_farthest() -> None:
    far, near = swing(8.0, 0.5, 1e-3), swing(20.0, 0.03, 1e-3)
    position = np.concatenate([far, near])[:, None]
    pieces = [slice(0, far.size), slice(far.size, position.size)]
    assert motion_frequency(near, RATE) > 90.0
    assert quickest_motion(position, pieces, RATE, [False]) == pytest.approx(
        0.5, abs=2.0 / 8.0
    )  # which eight seconds tell apart


@pytest.mark.parametrize("sliding", [False, True])
def test_a_joint_that_hardly_moves_beside_others_of_its_kind_is_not_asked(sliding: bool) -> None:
    position = np.column_stack([swing(20.0, 0.5, 0.0), swing(20.0, 0.01, 1e-3)])
    quickest = quickest_motion(position, [slice(0, position.shape[0])], RATE, [False, sliding])
    # How far a slide goes says nothing of how far others turn.
    assert (quickest > 90.0) is sliding


def test_where_nothing_moves_it_is_none() -> None:
    assert quickest_motion(np.zeros((100, 2)), [slice(0, 100)], RATE, [False, True]) == 0.0
