"""Channels that stand still in the middle of motion, or repeat themselves where they are noisy else."""

from __future__ import annotations

import numpy as np

from mjfriction.record.counts import count_of, least_jump
from mjfriction.record.runs import Floats, Integers, Mask, bounds_of, numbered, runs_of

SHORTEST_STUCK = 20  # samples
STUCK_SPEED = 0.4  # of the usual speed, just before or after a standstill, that no joint stops from at once
NEAR = 6  # samples beside a standstill, that tell how fast a joint was
KNOWN_BY = 3.5  # counts of an encoder, that a joint must have gone there for its speed to be known
NO_RUN_UP = 0.7  # of the speed further away, that a joint has right beside a standstill if it did not slow down for it
CAUGHT_UP = 2.5  # times the steps after it, that a reading makes which comes unstuck
WORKS_ON, SMOOTHED = 0.3, 9  # of an effort's usual spread, that it has while its joint moves; samples of a mean
LONGER = 4.0  # times the longest ordinary run of equal samples, for a run to be no rest of the encoder
MOVED = 0.3  # of a frozen stretch that the joint moves in: more than a rest with its run-down
RARELY = 0.01  # of the rows at rest, that noise repeats the one before in


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
    piece = numbered(piece, values.size)
    begin, end = np.searchsorted(piece, piece), np.searchsorted(piece, piece, side="right")
    runs = runs_of(values, piece, 2)
    if not runs or np.ptp(values) == 0.0:
        return out
    usual = float(np.sqrt(np.mean(np.square(speed))))
    jump, count = least_jump(values, piece), count_of(values)
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
    lengths = np.sort(np.diff(bounds_of(values)))
    ordinary = float(lengths[int(0.99 * (lengths.size - 1))])
    again, resting = np.append(np.diff(values) == 0.0, False), np.logical_not(moving)
    for a, b in runs_of(values, None, max(SHORTEST_STUCK, LONGER * ordinary)):
        rows, repeated = (int(np.sum(own)) - int(np.sum(own[a:b])) for own in (resting, again & resting))
        noisy = rows > b - a and repeated < RARELY * rows
        if np.mean(moving[a:b]) > MOVED or (noisy and values[a] != 0.0):
            out[a:b] = True
    return out
