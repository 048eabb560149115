"""Channels that stand still in the middle of motion, or repeat one value where they are otherwise noisy."""

from __future__ import annotations

import numpy as np

from mjfriction.record.counts import count_of, least_jump
from mjfriction.record.runs import Floats, Integers, Mask, bounds_of, numbered, runs_of, spans

SHORTEST_STUCK = 20  # samples
STUCK_SPEED = 0.4  # of the usual speed; no joint stops at once from a higher speed just before or after a standstill
NEAR = 6  # samples beside a standstill, from which the joint's speed there is taken
KNOWN_BY = 3.5  # encoder counts that a joint must have moved in these samples for its speed to be known
NO_RUN_UP = 0.7  # of the speed farther away; a joint faster than this right beside a standstill did not slow down
CAUGHT_UP = 2.5  # times the largest step that follows; a reading that becomes unstuck makes a larger step than this
LOOSE = 10.0  # times the largest step beside a standstill: a step that no joint makes, however slow the one it ends
# Of an effort's earlier standard deviation; while its joint moves, the effort has more.  It is smoothed over SMOOTHED
# samples.
WORKS_ON, SMOOTHED = 0.3, 9
LONGER = 4.0  # times an ordinarily long run of equal samples; a shorter run is the encoder's resolution
MOVED = 0.3  # of a frozen stretch; the joint moves in more of it than in a rest together with the slowing down to it
RARELY = 0.01  # highest share of rows at rest in which a noisy channel repeats the row before


def stuck(
    values: Floats,
    speed: Floats,
    piece: Integers | None = None,
    effort: Floats | None = None,
    course: Floats | None = None,
) -> Mask:
    """Return where a channel abruptly stands still in the middle of motion, (n,).

    ``speed`` (n,) is the joint's speed from the neighbouring samples or from its velocity column.  A real rest has a
    run-down before it or a run-up after it.  A stuck channel has neither, and jumps to where the joint has moved.

    Where ``speed`` shows that the joint moves on during the standstill, the channel is stuck however it comes loose.
    ``course`` (n,), the integral of ``speed``, must then move too, as the noise of a measured velocity integrates to
    nothing.  ``piece`` (n,) numbers the stretches recorded without a break: the next one begins where the joint is by
    then.  A joint that stands still up to the end of a piece is at rest if its ``effort`` (n,) is steady as well; where
    no effort is given, it is stuck.
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
        # A coarse encoder flickers while its joint rests, and shows a creeping joint's speed only by single counts.
        came = abs(values[first] - values[a]) > KNOWN_BY * count
        before, after = np.abs(speed[first:a]), np.abs(speed[b - 1 : past])
        # A stuck reading makes up for the hidden motion in one step.  The first step of a joint that starts to move is
        # no longer than those that follow.
        after_it = float(np.max(np.abs(np.diff(values[b:past])), initial=0.0))
        # Slow beside the joint's usual pace, a standstill that begins at once and ends in a step like no other beside
        # it is none of the joint's.
        beside = max(float(np.max(np.abs(np.diff(values[first : a + 1])), initial=0.0)), after_it)
        torn = came and _at_once(before[::-1], 0.0) and step > max(LOOSE * beside, KNOWN_BY * count)
        if step > jump or torn:
            out[a:b] = True
            continue
        if b - a < LONGER * ordinary:
            continue
        went = abs(values[min(past, int(end[a]) - 1)] - values[b - 1]) > KNOWN_BY * count
        from_motion = came and _at_once(before[::-1], usual)
        into_motion = went and _at_once(after, usual) and step > CAUGHT_UP * after_it
        # A measured velocity shows motion during the standstill, even if the drive's filter delays it.
        moving = float(np.median(np.abs(speed[(a + b) // 2 : b - 1]))) > STUCK_SPEED * usual
        moving = moving and (course is None or float(np.ptp(course[a:b])) > KNOWN_BY * count)
        if moving or (from_motion and into_motion):
            out[a:b] = True
        elif into_motion or (from_motion and (effort is None or b < end[a] or _works_on(effort[begin[a] : b], b - a))):
            # A joint held by stiction also stops abruptly, but moves on from where it was.  Beyond the end of a piece,
            # nothing is known.
            if a == begin[a] or b == end[a]:
                open_ended.append((a, b))
            else:
                sticks = True
    for a, b in [] if sticks else open_ended:
        out[a:b] = True
    return out


def _works_on(effort: Floats, last: int) -> bool:
    # Whether an effort, smoothed against noise, varies in its ``last`` samples about as much as before.
    spread = [
        float(np.std(np.convolve(own, np.ones(SMOOTHED) / SMOOTHED, mode="valid"))) if own.size >= SMOOTHED else 0.0
        for own in (effort[:-last], effort[-last:])
    ]
    return spread[1] > WORKS_ON * spread[0]


def _at_once(speed: Floats, usual: float) -> bool:
    # Whether speeds (k,), ordered from the standstill outwards, are high, and not lower right beside it than farther
    # away.
    if speed.size < 4:
        return False
    beyond = float(np.median(speed[1:]))
    return bool(beyond > STUCK_SPEED * usual and speed[0] > NO_RUN_UP * beyond)


def frozen(values: Floats, moving: Mask) -> Mask:
    """Return where a noisy channel repeats one value exactly while its joint moves, (n,).

    However long the joint rests besides, it is enough that it sets out within the stretch and keeps moving.  A stretch
    at rest counts as well, if more other rows at rest show that the channel is noisy there, and the value is not 0,
    which a drive reads that is switched off.
    """
    out = np.zeros(values.size, dtype=bool)
    lengths = np.sort(np.diff(bounds_of(values)))
    ordinary = float(lengths[int(0.99 * (lengths.size - 1))])
    again, resting = np.append(np.diff(values) == 0.0, False), np.logical_not(moving)
    least = max(SHORTEST_STUCK, LONGER * ordinary)
    for a, b in runs_of(values, None, least):
        rows, repeated = (int(np.sum(own)) - int(np.sum(own[a:b])) for own in (resting, again & resting))
        noisy = rows > b - a and repeated < RARELY * rows
        if np.mean(moving[a:b]) > MOVED or _sets_out(moving[a:b], least) or (noisy and values[a] != 0.0):
            out[a:b] = True
    return out


def _sets_out(moving: Mask, least: float) -> bool:
    # Whether a joint that rested moves for so many samples.
    return any(first > 0 for first, past in spans(moving) if past - first >= least)
