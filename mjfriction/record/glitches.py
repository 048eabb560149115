"""Detection of single wild samples of a channel."""

from __future__ import annotations

import numpy as np

from mjfriction.record.counts import QUANTA, count_of
from mjfriction.record.runs import Floats, Integers, Mask, spans

LONGEST_SINGLE = 2  # samples of a glitch
WILD = 25.0  # times the usual (99 % quantile) deviation from the median of its neighbours; a wild sample exceeds it
COMES_BACK = 0.3  # of a wild sample's height; its two neighbours must differ by less
FORESEEN = 0.8  # of that height; a wild sample must deviate by more from a linear extrapolation up to it
WILD_SHARE = 0.02  # of a channel's range; a wild sample must deviate from the median by more than this as well
LEAST_WILD = 1e-9  # in the channel's unit: less is the rounding of a simulation
COURSE = np.arange(1, 7)  # samples beyond a wild sample's neighbour, through which a straight line is fitted
TOUCHED = 0.03  # of a wild sample's height; a neighbour that deviates from that line by more is part of a blow
SPREADS = 5.0  # the same, in standard deviations of the samples around that line
PACE, CALM = 4, 12  # samples over which a joint's speed is taken, and of the calm before and after a blow
# A change of speed is a jump beyond this many times the largest change in the calm, plus this many encoder counts.
JUMPS, COUNTS = 2.0, 3.0


def glitches(values: Floats) -> Mask:
    """Return the single wild samples of a channel, (n,): far from the median of the samples around them."""
    if values.size < 16 or np.ptp(values) == 0.0:
        return np.zeros(values.size, dtype=bool)
    padded = np.pad(values, 3, mode="edge")
    around = np.median(np.lib.stride_tricks.sliding_window_view(padded, 7), axis=1)
    departure = np.abs(values - around)
    usual = float(np.quantile(departure, 0.99)) + 1e-300
    spread = float(np.quantile(values, 0.99) - np.quantile(values, 0.01))
    wild = departure > max(WILD * usual, WILD_SHARE * spread, QUANTA * count_of(values), LEAST_WILD)
    out = wild.copy()
    for start, stop in spans(wild):
        if stop - start > LONGEST_SINGLE or not _there_and_back(values, wild, start, stop):
            out[start:stop] = False
    return out


def _there_and_back(values: Floats, wild: Mask, start: int, stop: int) -> bool:
    # A wild sample stands out from both neighbours, which are alike; a step or a swing does not come back.  A sample
    # that a linear extrapolation from either side predicts is no glitch: the signal turns there.  The extrapolation
    # needs two samples on its side, neither of them wild.
    if start == 0 or stop == values.size:
        return True
    before, after = values[start - 1], values[stop]
    height = np.min(np.abs(values[start:stop] - 0.5 * (before + after)))
    if abs(after - before) >= COMES_BACK * height:
        return False
    sides = ((start - 1, start - 2, start), (stop, stop + 1, stop - 1))
    courses = [own for own in sides if 0 <= own[1] < values.size and not wild[own[1]]]
    return all(abs(2.0 * values[a] - values[b] - values[at]) > FORESEEN * height for a, b, at in courses)


def felt(wild: Mask, effort: Floats, position: Floats, piece: Integers) -> Mask:
    """Return which wild samples of an effort, (n,), are real blows to the machine.

    A wrong reading affects neither its neighbours nor the joint's motion.  A blow begins before its sample or decays
    after it, or the joint's speed jumps there.  ``position`` (n,) is the joint's; ``piece`` (n,) numbers the stretches
    recorded without a break.
    """
    out, places = np.zeros(wild.size, dtype=bool), spans(wild)
    if not places:
        return out
    change = np.zeros(wild.size)
    change[PACE:-PACE] = np.abs(position[2 * PACE :] - 2.0 * position[PACE:-PACE] + position[: -2 * PACE])
    effort_count = count_of(effort)
    count = count_of(position) if np.ptp(position) > 0.0 else np.inf
    for start, stop in places:
        out[start:stop] = _touches(effort, wild, piece, start, stop, effort_count) or _answered(
            change, piece, start, stop, count
        )
    return out


def _touches(effort: Floats, wild: Mask, piece: Integers, start: int, stop: int, count: float) -> bool:
    # Whether a neighbour deviates from the straight line through the samples beyond it.
    before, after = effort[max(start - 1, 0)], effort[min(stop, effort.size - 1)]
    height = np.max(np.abs(effort[start:stop] - 0.5 * (before + after)))
    for neighbour, way in ((start - 1, -1), (stop, 1)):
        beyond = neighbour + way * COURSE
        if np.min(beyond) < 0 or np.max(beyond) >= effort.size or np.any(wild[beyond]):
            continue
        if np.ptp(piece[[start, *beyond]]) > 0:
            continue
        line = np.polynomial.polynomial.polyfit(COURSE, effort[beyond], 1)
        spread = float(np.std(effort[beyond] - np.polynomial.polynomial.polyval(COURSE, line)))
        off = abs(effort[neighbour] - line[0])
        if off > max(TOUCHED * height, SPREADS * spread, QUANTA * count):
            return True
    return False


def _answered(change: Floats, piece: Integers, start: int, stop: int, count: float) -> bool:
    # Whether the joint's speed jumps: it changes far more than before and after, unlike where a path starts or stops
    # bending.
    first, past = start - 2 * PACE - CALM, stop + 2 * PACE + CALM
    if first < 0 or past > change.size or np.ptp(piece[first:past]) > 0:
        return False
    around = max(np.max(change[first + PACE : start - PACE]), np.max(change[stop + PACE : past - PACE]))
    return bool(np.max(change[start:stop]) > JUMPS * around + COUNTS * count)
