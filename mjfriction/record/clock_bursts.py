"""Rows that came in bursts and were stamped on arrival rather than when sampled: only their time is wrong."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mjfriction.record.clock import SURE, Steps, evenness, put_right, steps_of
from mjfriction.record.fault import Fault, in_words
from mjfriction.record.log import Floats, Log
from mjfriction.record.runs import spans

AT_ONCE, WAITED = 0.3, 1.7  # of the ordinary step: below the first, rows came at once; above the second, it was a pause
LONG = 10.0  # a step longer than this many median steps is a pause, where rows came in bursts throughout
FEWEST_AT_ONCE, MOST_AT_ONCE = 3, 1000  # rows of a burst
FEWEST_BURSTS = 8  # needed to estimate the step at which rows were sampled
ALIKE = 0.5  # of the median; a burst whose time per row deviates by more has missing rows, and is left out
WHOLE = 0.5  # ordinary steps; a stretch that deviates from its row count by more has missing rows
DRIFT = 0.01  # of a stretch's length, allowed in addition to WHOLE


def without_bursts(log: Log) -> Log:
    """Return the log with even time where rows came in bursts, and a fault that reports it.

    A stretch is corrected where no rows are missing, unless the joints' positions are clearly smoother along the
    clock than from row to row.  A machine at rest decides nothing, so its stretches are corrected too.
    """
    steps = steps_of(log)
    if steps is None:
        return log
    ordinary = burst_step(steps) or steps.ordinary
    time, places, most = log.time.copy(), [], 0
    for first, end in spans(_odd(steps, ordinary)):
        at_once = _rows_at_once(steps.length[first:end], ordinary)
        even = _even(log.time, first, end, ordinary, at_once)
        if at_once < FEWEST_AT_ONCE or even is None or evenness(log, first, end) <= -SURE:
            continue
        time[first : end + 1] = even
        places.append((float(log.time[first]), float(log.time[end])))
        most = max(most, at_once)
    if not places:
        return log
    how = f"up to {most} rows came at once after a pause, though the joints went on evenly: so does time there"
    return put_right(log, time, [Fault("data.clock", in_words(places), how)])


def burst_step(steps: Steps) -> float | None:
    """Return the step (s) at which rows were sampled that came in bursts throughout, None where they did not.

    Most steps of such a log are nearly zero.  A pause usually lasts as long as its burst took to sample.
    """
    within = np.where(steps.joined, steps.length, np.nan)
    waits = np.flatnonzero(within > LONG * max(float(np.nanmedian(within)), float(np.finfo(float).tiny)))
    rows = np.diff(waits)
    if rows.size < FEWEST_BURSTS or np.median(rows) < FEWEST_AT_ONCE or np.median(rows) > MOST_AT_ONCE:
        return None
    took = np.diff(np.cumsum(np.nan_to_num(within))[waits])
    # Packets of equal duration alternate between one row more and one row fewer, so the sum over many is used.
    whole = np.abs(took / rows / np.median(took / rows) - 1.0) < ALIKE
    return float(np.sum(took[whole]) / np.sum(rows[whole]))


def _odd(steps: Steps, ordinary: float) -> NDArray[np.bool_]:
    # Marks the steps of bursts and the pauses between them.  A pause longer than the bursts beside it is not one of
    # them: the recording paused, or rows are missing.
    short = steps.joined & (steps.length >= 0.0) & (steps.length < AT_ONCE * ordinary)
    odd = short | (steps.joined & (steps.length > WAITED * ordinary))
    for k in np.flatnonzero(odd & ~short).tolist():
        before, after = short[:k][::-1], short[k + 1 :]
        beside = max(int(np.argmin(np.append(part[:MOST_AT_ONCE], False))) for part in (before, after))
        odd[k] = steps.length[k] < (beside + 1 + FEWEST_AT_ONCE * WHOLE) * ordinary
    return odd


def _even(time: Floats, first: int, end: int, ordinary: float, at_once: int) -> Floats | None:
    # When the rows of a stretch were sampled; None where some are missing.  A burst at either end of the stretch may
    # lack its pause: the rows beyond belong to another stretch, or are lost.
    count, took = end - first, (time[end] - time[first]) / ordinary
    short = count - (at_once - 1)
    if min(abs(took - count), abs(took - short)) > WHOLE + DRIFT * count:
        return None
    if abs(took - count) <= abs(took - short):
        return np.linspace(time[first], time[end], count + 1)
    course: Floats = ordinary * np.arange(count + 1.0)
    if end + 1 == time.size or time[first] + course[-1] < time[end + 1]:
        return np.asarray(time[first] + course)
    earlier: Floats = time[end] - course[::-1]
    return earlier if first == 0 or earlier[0] > time[first - 1] else None


def _rows_at_once(length: Floats, ordinary: float) -> int:
    return max((b - a + 1 for a, b in spans(length < AT_ONCE * ordinary)), default=0)
