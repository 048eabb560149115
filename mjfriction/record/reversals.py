"""How far joints are from where they last turned back."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from mjfriction.record.log import Floats


def travel_since_turn(velocity: Floats, position: Floats, pieces: Sequence[slice]) -> tuple[Floats, NDArray[np.bool_]]:
    """Return how far each joint is from where it last turned back (rad or m), and whether that is known, (n, joints).

    ``velocity`` and ``position`` are (n, joints), and ``pieces`` the samples recorded without a break.  Before the
    first turn in a piece, where it is not known, it is how far the joint is from where the piece began.
    """
    travel, known = np.empty_like(position), np.empty(position.shape, dtype=bool)
    for own in pieces:
        course = position[own]
        turned = np.zeros(course.shape, dtype=bool)
        turned[1:] = np.diff(np.sign(velocity[own]), axis=0) != 0.0
        last = np.maximum.accumulate(np.where(turned, np.arange(len(course))[:, None], 0), axis=0)
        travel[own] = np.abs(course - np.take_along_axis(course, last, axis=0))
        known[own] = np.logical_or.accumulate(turned, axis=0)
    return travel, known
