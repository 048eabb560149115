"""Faults that the recording itself brought into a log: rows repeated, channels stuck or clipped, single wild samples.

They are found in the samples alone, before any model is asked, and repaired where that is safe.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mjfriction.record.span import EVER, Span

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
Mask = NDArray[np.bool_]

FEWEST_REPEATED = 8  # rows, different ones, alike in every column, that no chance repeats in a row
SHORTEST_STUCK = 20  # samples
STUCK_SPEED = 0.4  # of the usual speed, just before or after a standstill, that no joint stops from at once
NEAR = 6  # samples beside a standstill, that tell how fast a joint was
KNOWN_BY = 3.5  # counts of an encoder, that a joint must have gone there for its speed to be known
NO_RUN_UP = 0.7  # of the speed further away, that a joint has right beside a standstill if it did not slow down for it
CAUGHT_UP = 2.5  # times the steps after it, that a reading makes which comes unstuck
WORKS_ON, SMOOTHED = 0.3, 9  # of an effort's usual spread, that it has while its joint moves; samples of a mean
ALL_BUT_JUMPS, JUMP = 0.999, 5.0  # quantile of a channel's steps, and how many of it no joint makes at once
LONGER = 4.0  # times the longest ordinary run of equal samples, for a run to be no rest of the encoder
MOVED = 0.3  # of a frozen stretch that the joint moves in: more than a rest with its run-down
RARELY = 0.01  # of the rows at rest, that noise repeats the one before in
FEWEST_CLIPPED = 12  # samples at the same extreme, in runs
CLIPPED_RUN = 4  # samples of one of them at least
AT_THE_EDGE = 8.0  # times the samples at the extreme must be more than those beside it
MOST_LISTED = 3  # places of one fault that are spelled out
LEAVES = 0.5  # of the range, that no effort leaves a limit by at once
BESIDE = 0.02  # of the range, that is beside the extreme
QUANTA, OF_QUANTA = 2.5, 0.5  # the same of a channel whose steps are coarser than that, in steps
PEAKED = 2.5  # times the samples one step inside, that a smooth peak has in its highest step at most: √1 to √2 − √1
LONGEST, OUTLASTS = 20, 5.0  # samples of a run at the extreme, and times the longest elsewhere, that noise never leaves
LONG_AGO = 1e5  # s, past which a clock did not begin with its log
HEAPED = 2.0  # times the samples one step inside, that are heaped up at either extreme of what a coarse sensor reads


@dataclass(frozen=True)
class Mend:
    """How columns of a log should have been read: times a factor each, or two in each other's place, within a ``span``
    of time (s).
    """

    factors: tuple[tuple[str, float], ...] = ()
    exchanged: tuple[tuple[str, str], ...] = ()
    span: Span = EVER


@dataclass(frozen=True)
class Fault:
    """A fault of a log: its ``kind`` (``data.stuck``, …), where, and what was done or is to do; ``spans`` are the
    times (s) of the rows that were left out, ``mend`` is how the log is read right where that is known.
    """

    kind: str
    where: str
    action: str
    spans: tuple[Span, ...] = ()
    mend: Mend | None = None


def written_again(time: Floats, segment: Integers, columns: Mapping[str, Floats]) -> Mask:
    """Return which rows are an earlier row once more, its time and all, (n,)."""
    if np.all(np.diff(time) > 0.0):
        return np.zeros(time.size, dtype=bool)
    rows = _as_one(np.column_stack([time, segment.astype(np.float64), *columns.values()]))
    _, first = np.unique(rows, return_index=True)
    again = np.ones(rows.size, dtype=bool)
    again[first] = False
    return again


def _as_one(table: Floats) -> NDArray[np.void]:
    # Rows (n, columns) as values that can be compared as one, (n,).
    table = np.ascontiguousarray(table)
    return table.view(np.dtype((np.void, table.dtype.itemsize * table.shape[1])))[:, 0]


def repeated_rows(columns: Mapping[str, Floats]) -> Mask:
    """Return which rows repeat earlier ones, many in a row and alike in every column, time left aside, (n,)."""
    rows = _as_one(np.column_stack([columns[name] for name in sorted(columns)]))
    _, number = np.unique(rows, return_inverse=True)
    out = np.zeros(rows.size, dtype=bool)
    last: dict[int, int] = {}
    lag = np.zeros(rows.size, dtype=np.int64)
    for i, own in enumerate(number.tolist()):
        lag[i] = i - last.get(own, i)
        last[own] = i
    for start, stop in _runs(lag):
        # A resting machine repeats the row before, and one that reads coarsely few rows again and again: only rows that
        # differ among themselves were copied.
        if lag[start] > 1 and np.unique(number[start:stop]).size >= FEWEST_REPEATED:
            out[start:stop] = True
    return out


def held_rows(columns: Mapping[str, Floats], piece: Integers | None = None) -> Mask:
    """Return which rows are the row before once more, in every column and many in a row, while the machine moves on:
    what a recorder writes that has stalled, time left aside, (n,).

    ``piece`` (n,) numbers what was recorded without a break.
    """
    joined = np.diff(_pieces(piece, len(next(iter(columns.values()))))) == 0
    again = np.append(False, np.logical_and.reduce([joined, *(own[1:] == own[:-1] for own in columns.values())]))
    out = np.zeros(again.size, dtype=bool)
    held = [(a, b) for a, b in _runs(again.astype(np.int64)) if again[a] and b - a >= FEWEST_REPEATED - 1]
    if not held:
        return out
    elsewhere = np.zeros(again.size + 1, dtype=bool)
    for values in columns.values():
        if np.ptp(values) > 0.0:
            elsewhere[1:-1] |= joined & (np.abs(np.diff(values)) > _jump(values, piece))
    for start, stop in held:
        # A machine that rests stays where it was; one that moved on is elsewhere at once.
        out[start:stop] = elsewhere[stop]
    return out


def stuck(
    values: Floats,
    speed: Floats,
    piece: Integers | None = None,
    effort: Floats | None = None,
    course: Floats | None = None,
) -> Mask:
    """Return where a channel stands still at once in the middle of motion, (n,).

    ``speed`` (n,) is how fast the joint moves by another account (its own neighbours' samples, or its velocity column).
    A rest has a run-down before or a run-up after; a stuck channel has not, and is at once where the joint has gone.
    Where it moves on by that account, it is stuck however it comes loose; ``course`` (n,) is where it is by then: the
    noise of a velocity goes nowhere.  ``piece`` (n,) numbers what was recorded without a break: the next one begins
    where the joint is by then.  A joint that stands still up to the end of one rests where its ``effort`` (n,) rests
    too; where none is given it is stuck.
    """
    out = np.zeros(values.size, dtype=bool)
    piece = _pieces(piece, values.size)
    begin, end = np.searchsorted(piece, piece), np.searchsorted(piece, piece, side="right")
    runs = _runs(values, piece, 2)
    if not runs or np.ptp(values) == 0.0:
        return out
    usual = float(np.sqrt(np.mean(np.square(speed))))
    jump, count = _jump(values, piece), count_of(values)
    lengths = np.sort([b - a for a, b in runs])
    ordinary = float(lengths[int(0.9 * (lengths.size - 1))]) if lengths.size > 10 else 2.0
    open_ended, sticks = [], False
    for a, b in runs:
        if b - a < SHORTEST_STUCK:
            continue
        first, past = max(a - NEAR, int(begin[a])), min(b - 1 + NEAR, int(end[a]))
        step = abs(values[b] - values[b - 1]) if b < end[a] else 0.0
        if step > jump:
            out[a:b] = True
        if step > jump or b - a < LONGER * ordinary:
            continue
        # A coarse encoder flickers while its joint rests, and of one that creeps it tells the pace by single counts.
        came = abs(values[first] - values[a]) > KNOWN_BY * count
        went = abs(values[min(past, int(end[a]) - 1)] - values[b - 1]) > KNOWN_BY * count
        before, after = np.abs(speed[first:a]), np.abs(speed[b - 1 : past])
        from_motion = came and _at_once(before[::-1], usual)
        # What was hidden of a motion is made up for in one step; a joint that begins to move makes no longer one than
        # those that follow.
        into_motion = went and _at_once(after, usual)
        into_motion = into_motion and step > CAUGHT_UP * float(np.max(np.abs(np.diff(values[b:past])), initial=0.0))
        # A velocity that is measured says so itself, though it be filtered late.
        moving = float(np.median(np.abs(speed[(a + b) // 2 : b - 1]))) > STUCK_SPEED * usual
        moving = moving and (course is None or float(np.ptp(course[a:b])) > KNOWN_BY * count)
        if moving or (from_motion and into_motion):
            out[a:b] = True
        elif into_motion or (from_motion and (effort is None or b < end[a] or _works_on(effort[begin[a] : b], b - a))):
            # A joint that sticks stops at once too, and begins where it was; beyond a piece's end nothing is known.
            if a == begin[a] or b == end[a]:
                open_ended.append((a, b))
            else:
                sticks = True
    for a, b in [] if sticks else open_ended:
        out[a:b] = True
    return out


def _works_on(effort: Floats, last: int) -> bool:
    # Whether an effort goes up and down in its last samples as it did before, short of its noise.
    spread = [
        float(np.std(np.convolve(own, np.ones(SMOOTHED) / SMOOTHED, mode="valid"))) if own.size >= SMOOTHED else 0.0
        for own in (effort[:-last], effort[-last:])
    ]
    return spread[1] > WORKS_ON * spread[0]


def count_of(values: Floats) -> float:
    """Return what a coarse sensor counts in: the least step of a channel (n,) that is not constant."""
    steps = np.abs(np.diff(values))
    return float(np.min(steps[steps > 0.0]))


def _jump(values: Floats, piece: Integers | None = None) -> float:
    # A step that nothing makes that is recorded without a break.
    steps = np.abs(np.diff(values))[np.diff(_pieces(piece, values.size)) == 0]
    return max(JUMP * float(np.quantile(steps, ALL_BUT_JUMPS)), QUANTA * count_of(values))


def _pieces(piece: Integers | None, count: int) -> Integers:
    return np.zeros(count, dtype=np.int64) if piece is None else piece


def _at_once(speed: Floats, usual: float) -> bool:
    # Speeds (k,) from the standstill outwards: fast, and no slower right beside it than further away.
    if speed.size < 4:
        return False
    beyond = float(np.median(speed[1:]))
    return bool(beyond > STUCK_SPEED * usual and speed[0] > NO_RUN_UP * beyond)


def frozen(values: Floats, moving: Mask) -> Mask:
    """Return where a noisy channel repeats one value exactly while its joint moves, (n,); or while it rests, where that
    is noisy in as many other rows at rest, and the value is none that a drive reads which is switched off.
    """
    out = np.zeros(values.size, dtype=bool)
    lengths = np.sort(np.diff(_bounds(values)))
    ordinary = float(lengths[int(0.99 * (lengths.size - 1))])
    again, resting = np.append(np.diff(values) == 0.0, False), np.logical_not(moving)
    for a, b in _runs(values, None, max(SHORTEST_STUCK, LONGER * ordinary)):
        rows, repeated = (int(np.sum(own)) - int(np.sum(own[a:b])) for own in (resting, again & resting))
        noisy = rows > b - a and repeated < RARELY * rows
        if np.mean(moving[a:b]) > MOVED or (noisy and values[a] != 0.0):
            out[a:b] = True
    return out


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
        runs = [(a, b) for a, b in _runs(at.astype(np.int64)) if at[a]]
        longest = max((b - a for a, b in runs), default=0)
        if len(runs) == 1 and _breaks_off(values, *runs[0], LEAVES * span):
            continue  # a reading that stuck once, higher than others happen to be
        if np.count_nonzero(at & moving) >= FEWEST_CLIPPED and longest >= CLIPPED_RUN:
            standing.append(at)
            inside = np.count_nonzero(np.abs(np.abs(values - extreme) - step) < 0.5 * step)
            noisy = np.count_nonzero(at) < CLIPPED_RUN * len(runs)
            heaped.append(noisy and np.count_nonzero(at) > HEAPED * inside)
            flat = np.count_nonzero(at) > PEAKED * inside
            elsewhere = max((b - a for a, b in _runs(values) if not at[a] and np.any(moving[a:b])), default=0)
            outlasts = len(runs) > 1 and longest >= LONGEST and longest > OUTLASTS * elsewhere
            if outlasts or (flat and np.count_nonzero(at) * factor > np.count_nonzero(beside)):
                out |= at
    both_ways = abs(float(np.max(values)) + float(np.min(values))) <= 1e-9 * span
    clips = np.any(out) or heaped == [True, True]
    return np.logical_or.reduce([out, *standing]) if both_ways and clips else out


def _breaks_off(values: Floats, start: int, stop: int, by: float) -> bool:
    # Whether a run that is long enough for a reading which stuck ends where none that comes down from a limit goes on.
    return stop - start >= SHORTEST_STUCK and stop < values.size and bool(abs(values[stop] - values[start]) > by)


def _bounds(values: NDArray[np.generic], piece: Integers | None = None) -> Integers:
    # Where runs of equal values begin, and the end.
    cuts = np.flatnonzero((values[1:] != values[:-1]) | (np.diff(_pieces(piece, values.size)) != 0)) + 1
    return np.concatenate([[0], cuts, [values.size]])


def _runs(values: NDArray[np.generic], piece: Integers | None = None, least: float = 1.0) -> list[tuple[int, int]]:
    # The runs (first, past) of equal values that are as long as the least.
    bounds = _bounds(values, piece)
    long = np.flatnonzero(np.diff(bounds) >= least)
    return list(zip(bounds[long].tolist(), bounds[long + 1].tolist(), strict=True))


def in_words(places: Sequence[tuple[float, float]]) -> str:
    """Return stretches of time (s) as words, all but the first few of them counted."""
    words = [f"{moment(a)} s" if a == b else f"{moment(a)} s to {moment(b)} s" for a, b in places[:MOST_LISTED]]
    more = len(places) - MOST_LISTED
    return ", ".join(words) + (f" and {more} more places" if more > 0 else "")


def moment(time: float) -> str:
    """Return a time (s) in figures; seconds since 1970 have ten before the point."""
    return f"{time:.6g}" if abs(time) < LONG_AGO else f"{time:.3f}"


def spans(mask: Mask) -> list[tuple[int, int]]:
    """Return the runs (first, past) in which a mask holds."""
    return [(a, b) for a, b in _runs(mask.astype(np.int64)) if mask[a]]
