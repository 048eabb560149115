"""Channels that stand at their own extreme: drives that gave no more."""

from __future__ import annotations

import numpy as np

from mjfriction.record.counts import QUANTA
from mjfriction.record.runs import Floats, Mask, runs_of
from mjfriction.record.stuck import SHORTEST_STUCK

FEWEST_CLIPPED = 12  # samples at the same extreme, in runs
CLIPPED_RUN = 4  # samples of one of them at least
AT_THE_EDGE = 8.0  # times the samples at the extreme must be more than those beside it
LEAVES = 0.5  # of the range, that no effort leaves a limit by at once
BESIDE = 0.02  # of the range, that is beside the extreme
OF_QUANTA = 0.5  # of the samples beside the extreme, where QUANTA steps are coarser than that
PEAKED = 2.5  # times the samples one step inside, that a smooth peak has in its highest step at most: √1 to √2 − √1
LONGEST, OUTLASTS = 20, 5.0  # samples of a run at the extreme, and times the longest elsewhere, that noise never leaves
HEAPED = 2.0  # times the samples one step inside, that are heaped up at either extreme of what a coarse sensor reads


def clipped(values: Floats, moving: Mask) -> Mask:
    """Return where a channel stands at its own extreme, (n,): many samples at one value, few beside it.

    A drive that clips one way clips the other way too, at as much: there it is enough that it often stays there.  Noise
    that is clipped heaps up at both extremes, in short runs; where all of it is cut off, it stays there as long as
    nowhere else.
    """
    out, standing, heaped = np.zeros(values.size, dtype=bool), [], []
    span = float(np.ptp(values))
    if span <= 0.0:
        return out
    step = float(np.median(np.diff(np.unique(values))))
    beyond, factor = (BESIDE * span, AT_THE_EDGE) if QUANTA * step < BESIDE * span else (QUANTA * step, OF_QUANTA)
    for extreme in (float(np.max(values)), float(np.min(values))):
        at = np.abs(values - extreme) <= 1e-9 * span
        beside = (np.abs(values - extreme) <= beyond) & ~at
        runs = [(a, b) for a, b in runs_of(at.astype(np.int64)) if at[a]]
        longest = max((b - a for a, b in runs), default=0)
        if len(runs) == 1 and _breaks_off(values, *runs[0], LEAVES * span):
            continue  # a reading that stuck once, higher than others happen to be
        if np.count_nonzero(at & moving) >= FEWEST_CLIPPED and longest >= CLIPPED_RUN:
            standing.append(at)
            inside = np.count_nonzero(np.abs(np.abs(values - extreme) - step) < 0.5 * step)
            noisy = np.count_nonzero(at) < CLIPPED_RUN * len(runs)
            heaped.append(noisy and np.count_nonzero(at) > HEAPED * inside)
            flat = np.count_nonzero(at) > PEAKED * inside
            elsewhere = max((b - a for a, b in runs_of(values) if not at[a] and np.any(moving[a:b])), default=0)
            outlasts = len(runs) > 1 and longest >= LONGEST and longest > OUTLASTS * elsewhere
            if outlasts or (flat and np.count_nonzero(at) * factor > np.count_nonzero(beside)):
                out |= at
    both_ways = abs(float(np.max(values)) + float(np.min(values))) <= 1e-9 * span
    clips = np.any(out) or heaped == [True, True]
    return np.logical_or.reduce([out, *standing]) if both_ways and clips else out


def _breaks_off(values: Floats, start: int, stop: int, by: float) -> bool:
    # Whether a run that is long enough for a reading which stuck ends where none that comes down from a limit goes on.
    return stop - start >= SHORTEST_STUCK and stop < values.size and bool(abs(values[stop] - values[start]) > by)
