"""A clock that ran to and fro for a while: rows were written out of order, or stamped at random."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mjfriction.record.clock import CHUNK, SURE, Steps, evenness, put_right, steps_of
from mjfriction.record.clock_bursts import DRIFT, WHOLE
from mjfriction.record.fault import Fault, in_words
from mjfriction.record.log import Log
from mjfriction.record.runs import Mask, spans

UNEVEN = 0.2  # of the ordinary step; a step that deviates by more belongs to the stretch beside it
MOST_UNEVEN = 0.5  # share of uneven steps from which on the median step is none of the clock's
BETWEEN = 10  # rows that may be evenly stamped within a stretch
FARTHEST = 50.0  # ordinary steps that a row's time may be off; beyond, the clock was set, or another motion begins


def with_time_in_order(log: Log) -> Log:
    """Return the log with time that increases where it ran to and fro within a segment, and faults that say so.

    Where the joints' positions are clearly smoother along the clock than from row to row, the rows are put in its
    order.  Where they are not, the rows are in order, and their time is spread evenly if none is far off.  A stretch in
    which rows are missing, or of which there are too many, is left as it is: two motions may have been recorded without
    a segment number.
    """
    steps = steps_of(log)
    if steps is None or not np.any(steps.joined & (steps.length < 0.0)):
        return log
    time, order = log.time.copy(), np.arange(log.time.size)
    evened, moved, crossed = [], [], _crossed(log)
    ordinary, uneven = _uneven(steps, crossed)
    for first, end in _closed(uneven & steps.joined, steps.joined):
        took, rows = (log.time[end] - log.time[first]) / ordinary, slice(first, end + 1)
        whole = abs(took - (end - first)) <= WHOLE + DRIFT * (end - first)
        if not (whole and np.any(steps.length[first:end] < 0.0)):
            continue
        by_clock = first + np.argsort(log.time[rows], kind="stable")
        even = np.linspace(log.time[first], log.time[end], end - first + 1)
        place = float(np.min(log.time[rows])), float(np.max(log.time[rows]))
        if evenness(log, first, end, by_clock) < -SURE * (1 + (end - first) // CHUNK):
            order[rows], time[rows] = by_clock, log.time[by_clock]
            moved.append(place)
        elif np.max(np.abs(log.time[rows] - even)) <= FARTHEST * ordinary:
            time[rows] = even
            evened.append(place)
    if moved:
        columns = {name: values[order] for name, values in log.columns.items()}
        log = replace(log, columns=columns, time=log.time[order])
    how = {
        "time ran to and fro, though the joints went on evenly: so does time there": evened,
        "rows were out of order: put in the order of their time": moved,
    }
    faults = [Fault("data.clock", in_words(places), action) for action, places in how.items() if places]
    return put_right(log, time, faults) if faults else log


def _uneven(steps: Steps, crossed: Mask) -> tuple[float, Mask]:
    # The ordinary step, and which steps deviate from it or are crossed.  Steps back count, for they make others longer;
    # where nearly all are uneven, the mean says more than the median.
    ordinary = float(np.median(steps.length[steps.joined]))
    uneven = crossed | (np.abs(steps.length - ordinary) > UNEVEN * ordinary)
    if np.mean(uneven[steps.joined]) < MOST_UNEVEN:
        return ordinary, uneven
    return float(np.mean(steps.length[steps.joined])), uneven


def _crossed(log: Log) -> Mask:
    # Marks each step (n − 1,) that time crosses more than once: some row after it is no later than one before it.
    latest, earliest = np.empty_like(log.time), np.empty_like(log.time)
    for number in np.unique(log.segment):
        own = log.segment == number
        latest[own] = np.maximum.accumulate(log.time[own])
        earliest[own] = np.minimum.accumulate(log.time[own][::-1])[::-1]
    return np.asarray((earliest[1:] <= latest[:-1]) & (np.diff(log.segment) == 0))


def _closed(mask: Mask, joined: Mask) -> list[tuple[int, int]]:
    # The runs of marked steps, those of one segment with only a few unmarked ones between them as one.
    out: list[tuple[int, int]] = []
    for first, end in spans(mask):
        if out and first - out[-1][1] <= BETWEEN and np.all(joined[out[-1][1] : first]):
            out[-1] = (out[-1][0], end)
        else:
            out.append((first, end))
    return out
