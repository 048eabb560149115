"""What a coarse sensor counts in, and the steps that no joint makes at once."""

from __future__ import annotations

import numpy as np

from mjfriction.record.runs import Floats, Integers, numbered

ALL_BUT_JUMPS, JUMP = 0.999, 5.0  # quantile of a channel's steps, and how many of it no joint makes at once
QUANTA = 2.5  # counts, that are no coarse step any more


def count_of(values: Floats) -> float:
    """Return what a coarse sensor counts in: the least step of a channel (n,) that is not constant."""
    steps = np.abs(np.diff(values))
    return float(np.min(steps[steps > 0.0]))


def least_jump(values: Floats, piece: Integers | None = None) -> float:
    """Return a step of a channel (n,) that nothing makes that is recorded without a break, by ``piece`` (n,)."""
    steps = np.abs(np.diff(values))[np.diff(numbered(piece, values.size)) == 0]
    return max(JUMP * float(np.quantile(steps, ALL_BUT_JUMPS)), QUANTA * count_of(values))
