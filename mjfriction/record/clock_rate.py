"""A clock that ran at another rate for a while, while rows were sampled as before: only their time is wrong."""

from __future__ import annotations

import numpy as np

from mjfriction.record.clock import SURE, put_right, roughness, steps_of
from mjfriction.record.fault import Fault, moment
from mjfriction.record.log import POSITION, VELOCITY, Log
from mjfriction.record.resample import GAP_STEPS
from mjfriction.record.runs import spans

OFF = 0.02  # of the ordinary step; a step that deviates by more counts as another rate
# Of a stretch's deviation from the ordinary rate; where its steps spread by more, the clock jitters and has no rate.
STEADY = 0.2
FEWEST = 30  # steps of a stretch, for its rate to be judged
WINDOW = 0.08  # s on each side of an edge of the stretch, where positions are checked for smoothness
FEWEST_AROUND, MOST_AROUND = 8, 60  # rows, limits of that window
CLOSE = 0.3  # share of the rate's logarithm; measured velocities must agree with the rate to within this


def without_clock_drift(log: Log) -> Log:
    """Return the log with its clock corrected where it ran at another, steady rate, and faults that report it.

    The clock is corrected only where the joints' motion shows that rows were sampled at the same rate as before.  It is
    kept where the motion shows that the sampling rate did change, and where the motion does not decide.
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
    # Whether the joints' positions are smooth across the stretch's two edges when rows are evenly spaced, but not along
    # the clock.  By a wrong clock, the speed of a joint that moves on evenly would jump at the edge.  Where positions
    # do not decide, measured velocities do.
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
    # Whether the joints' travel agrees with their measured velocities when rows are evenly spaced: the travel is then
    # 1/rate of the velocity's integral over the clock's steps.
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
