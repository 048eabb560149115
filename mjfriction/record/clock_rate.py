"""A clock that ran at another rate for a while, while the rows went on as before: only the time is wrong there."""

from __future__ import annotations

import numpy as np

from mjfriction.record.clock import SURE, put_right, roughness, steps_of
from mjfriction.record.fault import Fault, moment
from mjfriction.record.log import POSITION, VELOCITY, Log
from mjfriction.record.resample import GAP_STEPS
from mjfriction.record.runs import spans

OFF = 0.02  # of the ordinary step, from which on a step is another
STEADY = 0.2  # of what its steps are off by, that a stretch's steps may spread: a clock that jitters has no rate
FEWEST = 30  # rows of a stretch, that such a clock is told by
WINDOW = 0.08  # s on each side of an edge, that tell how fast the joints went
FEWEST_AROUND, MOST_AROUND = 8, 60  # rows of it
CLOSE = 0.3  # of the rate, in logarithm, that measured speeds may be off by


def without_clock_drift(log: Log) -> Log:
    """Return the log with its clock put right where it ran at another, steady rate though the joints' speeds tell that
    rows went on as evenly as before, and with that said.  Where they tell that rows came at another rate, or nothing
    tells, the clock is kept.
    """
    steps = steps_of(log)
    if steps is None:
        return log
    step, ordinary = steps.length, steps.ordinary
    other = steps.joined & (np.abs(step - ordinary) > OFF * ordinary) & (step < GAP_STEPS * ordinary) & (step > 0.0)
    new, faults = step.copy(), []
    for first, end in spans(other):
        rate = float(np.median(step[first:end])) / ordinary
        spread = float(np.quantile(np.abs(step[first:end] / ordinary - rate), 0.9))
        if end - first < FEWEST or spread > STEADY * abs(rate - 1.0) or not _went_on(log, first, end, rate, ordinary):
            continue
        new[first:end] = ordinary
        where = f"{moment(log.time[first])} s to {moment(log.time[end])} s"
        how = f"it ran {rate:.4g} times as fast as before, though the joints went on as evenly: so does time there"
        faults.append(Fault("data.clock", where, how))
    if not faults:
        return log
    time = log.time[0] + np.concatenate([[0.0], np.cumsum(new)])
    return put_right(log, time, faults)


def _went_on(log: Log, first: int, end: int, rate: float, ordinary: float) -> bool:
    # Whether the joints' courses go on smoothly over both edges of a stretch from row to row, and not by the clock,
    # by which a joint that goes on would change its speed at once; else what was measured of speeds tells.
    around = int(np.clip(round(WINDOW / ordinary), FEWEST_AROUND, MOST_AROUND))
    for_rows = 0.0
    for edge in (first, end):
        window = slice(edge - around, edge + around + 1)
        if window.start < 0 or window.stop > log.time.size or np.ptp(log.segment[window]) != 0:
            continue
        time = log.time[window] - log.time[edge]
        for joint in log.joints:
            course = log.columns[f"{POSITION}.{joint}"][window]
            if np.ptp(course) > 0.0:
                for_rows += roughness(course, time) - roughness(course, np.arange(-around, around + 1.0))
    return for_rows > 0.0 if abs(for_rows) > SURE else _measured_so(log, first, end, rate)


def _measured_so(log: Log, first: int, end: int, rate: float) -> bool:
    # Whether the joints went as far, at the speeds that were measured, as in evenly spaced rows: less by the rate than
    # by the clock.
    rows, shares = slice(first, end + 1), []
    for joint in log.joints:
        velocity = log.columns.get(f"{VELOCITY}.{joint}")
        if velocity is None:
            continue
        went = np.diff(log.columns[f"{POSITION}.{joint}"][rows])
        by_clock = 0.5 * (velocity[rows][1:] + velocity[rows][:-1]) * np.diff(log.time[rows])
        if np.any(by_clock):
            shares.append(float(np.dot(went, by_clock) / np.dot(by_clock, by_clock)))
    share = float(np.median(shares)) if shares else 1.0
    return bool(share > 0.0 and abs(np.log(share * rate)) < CLOSE * abs(np.log(rate)))
