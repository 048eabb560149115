"""Rows that came in bursts, stamped as they arrived and not as they were sampled: only the time is wrong there."""

from __future__ import annotations

import numpy as np

from mjfriction.record.clock import SURE, Steps, put_right, roughness, steps_of
from mjfriction.record.faults import Fault, in_words, spans
from mjfriction.record.log import POSITION, Floats, Log

AT_ONCE, WAITED = 0.3, 1.7  # of the ordinary step: shorter, rows came at once; longer, the recorder waited
FEWEST_AT_ONCE = 3  # rows of a burst
WHOLE = 0.5  # ordinary steps, by which a stretch may be longer or shorter than its rows: else some are missing
DRIFT = 0.01  # of a stretch besides
CHUNK = 48  # rows on which the joints' courses are held against both clocks


def without_bursts(log: Log) -> Log:
    """Return the log with even time where rows came in bursts, and with that said: none are missing there, and the
    joints' courses are smooth from row to row, not by the clock, or nothing moves.
    """
    steps = steps_of(log)
    if steps is None:
        return log
    ordinary = _ordinary(steps)
    odd = steps.joined & (steps.length >= 0.0)
    odd &= (steps.length < AT_ONCE * ordinary) | (steps.length > WAITED * ordinary)
    time, places, most = log.time.copy(), [], 0
    for first, end in spans(odd):
        even = np.linspace(log.time[first], log.time[end], end - first + 1)
        at_once = max((b - a + 1 for a, b in spans(steps.length[first:end] < AT_ONCE * ordinary)), default=0)
        missing = abs((log.time[end] - log.time[first]) / ordinary - (end - first))
        if at_once < FEWEST_AT_ONCE or missing > WHOLE + DRIFT * (end - first) or not _evenly(log, first, end):
            continue
        time[first : end + 1], most = even, max(most, at_once)
        places.append((float(log.time[first]), float(log.time[end])))
    if not places:
        return log
    how = f"up to {most} rows came at once after a pause, though the joints went on evenly: so does time there"
    return put_right(log, time, [Fault("data.clock", in_words(places), how)])


def _ordinary(steps: Steps) -> float:
    # Where most rows come in bursts, most steps are none.
    within = steps.length[steps.joined]
    mean = float(np.mean(within))
    return steps.ordinary if np.median(within) > AT_ONCE * mean else mean


def _evenly(log: Log, first: int, end: int) -> bool:
    for_rows = 0.0
    for begin in range(first, end, CHUNK):
        rows = slice(begin, min(begin + CHUNK, end) + 1)
        if rows.stop - rows.start < FEWEST_AT_ONCE:
            continue
        by_clock: Floats = log.time[rows] - log.time[begin]
        for joint in log.joints:
            course = log.columns[f"{POSITION}.{joint}"][rows]
            if np.ptp(course) > 0.0:
                for_rows += roughness(course, by_clock) - roughness(course, np.arange(float(course.size)))
    return for_rows > -SURE
