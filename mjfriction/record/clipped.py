"""Detection of clipped channels: they stay at their own extreme because the drive gave no more."""

from __future__ import annotations

import numpy as np

from mjfriction.record.counts import QUANTA
from mjfriction.record.runs import Floats, Mask, runs_of, spans
from mjfriction.record.stuck import SHORTEST_STUCK

FEWEST_CLIPPED = 12  # fewest samples at one extreme, over all runs, while the joint moves
CLIPPED_RUN = 4  # fewest samples of the longest of these runs
AT_THE_EDGE = 8.0  # the samples at the extreme, times this, must outnumber those beside it
LEAVES = 0.5  # share of the range; no effort comes off a limit by more than this in one sample
BESIDE = 0.02  # share of the range; samples this near the extreme lie beside it
OF_QUANTA = 0.5  # in place of AT_THE_EDGE for a coarse sensor, of which QUANTA steps are more than BESIDE
# The samples at the extreme must outnumber those one step inside by this factor.  A smooth peak has at most √1 to
# √2 − √1, 2.41 times as many, in its highest step.
PEAKED = 2.5
# An extreme is clipped where its longest run has at least this many samples, and more than this many times those of the
# longest run elsewhere: noise that is not cut off never stays so long.
LONGEST, OUTLASTS = 20, 5.0
FEWEST_STOPS = 2  # stretches at one value from which on they are a limit, where all are at an extreme
HEAPED = 2.0  # noise is clipped where an extreme has more than this many times the samples of one step inside


def clipped(values: Floats, moving: Mask) -> Mask:
    """Return where a channel stands at its own extreme, (n,): many samples at one value, few beside it.

    A drive that clips in one direction clips in the other too, at the same magnitude.  Where the extremes are symmetric
    and one is clipped, it is therefore enough that the channel often stays at the other.  Clipped noise piles up at
    both extremes, in short runs.  Where all of the noise is cut off, the channel stays at the extreme far longer than
    at any other value.
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
            continue  # a reading that got stuck once, at a value that happens to be the extreme
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


def stands_at_limits(values: Floats, held: Mask) -> Mask:
    """Return where a channel stands at an extreme, (n,), if it does so wherever it is ``held`` at one value in motion.

    A reading that sticks does so at any value, and hardly twice at the same; a drive always clips at its limit.
    """
    extremes = [float(np.max(values)), float(np.min(values))]
    reached = [extreme for extreme in extremes if np.any(held & (values == extreme))]
    at = np.isin(values, reached)
    return at if len(spans(held)) >= FEWEST_STOPS and np.all(at[held]) else np.zeros(values.size, dtype=bool)


def _breaks_off(values: Floats, start: int, stop: int, by: float) -> bool:
    # Whether a run is long enough to be a stuck reading, and ends with a larger step than an effort coming off a limit.
    return stop - start >= SHORTEST_STUCK and stop < values.size and bool(abs(values[stop] - values[start]) > by)
