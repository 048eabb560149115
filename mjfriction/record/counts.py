"""The resolution of a coarse sensor, and steps too large for a joint to make within one sample."""

from __future__ import annotations

import numpy as np

from mjfriction.record.runs import Floats, Integers, numbered

ALL_BUT_JUMPS, JUMP = 0.999, 5.0  # quantile of a channel's steps, and the multiple of it beyond which a step is a jump
QUANTA = 2.5  # counts; a larger step is not explained by a coarse sensor


def count_of(values: Floats) -> float:
    """Return the count of a coarse sensor: the smallest nonzero step of a channel (n,), which must not be constant."""
    steps = np.abs(np.diff(values))
    return float(np.min(steps[steps > 0.0]))


def least_jump(values: Floats, piece: Integers | None = None) -> float:
    """Return the least step of a channel (n,) that counts as a jump: none is as large within a ``piece`` (n,)."""
    steps = np.abs(np.diff(values))[np.diff(numbered(piece, values.size)) == 0]
    return max(JUMP * float(np.quantile(steps, ALL_BUT_JUMPS)), QUANTA * count_of(values))
