"""A clock with a coarser resolution than the sampling: some rows share one stamp, and only their time is wrong."""

from __future__ import annotations

import numpy as np

from mjfriction.record.clock import SURE, evenness, put_right, steps_of
from mjfriction.record.fault import Fault, moment
from mjfriction.record.log import Floats, Log

FEWEST_SHARED = 0.05  # least share of rows that have the stamp of the row before
# Share of the clock's resolution, by which steps may differ from its multiples, as stamps are written with few digits.
EVERY = 0.05
MISSING = 2.5  # sampling steps; a step that exceeds the resolution by more is a gap in the recording
FEWEST = 30  # rows of a stretch, for its clock to be judged


def without_coarse_clock(log: Log) -> Log:
    """Return the log with even time where its clock is too coarse, and a fault that reports it.

    Such a clock repeatedly stands still for a row or more and then advances by whole steps of its resolution, while the
    joints' positions are smooth from row to row.  Each stretch between gaps gets its own step and start, from the
    straight line through its stamps.
    """
    steps = steps_of(log)
    if steps is None or np.mean(steps.length[steps.joined] == 0.0) < FEWEST_SHARED:
        return log
    resolution, time = steps.ordinary, log.time.copy()
    row = float(np.mean(np.minimum(steps.length[steps.joined], 2.0 * resolution)))
    bounds = np.flatnonzero(~steps.joined | (np.abs(steps.length) > resolution + MISSING * row)) + 1
    likelier, every = 0.0, 0.0
    for first, past in zip([0, *bounds.tolist()], [*bounds.tolist(), time.size], strict=True):
        own = steps.length[first : past - 1]
        ticks = own / resolution
        if past - first < FEWEST or not np.all(np.abs(ticks - np.round(ticks)) < EVERY):
            continue
        likelier += evenness(log, first, past - 1)
        time[first:past] = _even(log.time[first:past])
        every = float(time[past - 1] - time[first]) / (past - first - 1)
    increasing = np.all(np.diff(time)[steps.joined] > 0.0)
    if likelier < SURE or not increasing:
        return log
    where = f"{moment(log.time[0])} s to {moment(log.time[-1])} s"
    how = f"it reads in steps of {resolution:.4g} s, and a row came every {every:.4g} s: time goes on evenly there"
    return put_right(log, time, [Fault("data.clock", where, how)])


def _even(stamps: Floats) -> Floats:
    rows: Floats = np.arange(float(stamps.size))
    slope, begin = np.polyfit(rows, stamps - stamps[0], 1)
    return np.asarray(stamps[0] + begin + slope * rows)
