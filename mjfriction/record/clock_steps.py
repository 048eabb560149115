"""A clock that was set back or ahead while the machine moved on: no rows are missing, only the time is wrong."""

from __future__ import annotations

import numpy as np

from mjfriction.record.clock import put_right, steps_of
from mjfriction.record.fault import Fault
from mjfriction.record.log import POSITION, Floats, Log
from mjfriction.record.resample import GAP_STEPS

AROUND = 10  # rows on each side of a clock jump, from which the joints' speeds are estimated
MOVED = 20.0  # times a position's noise; a joint must travel farther than this on both sides to be evidence
# Of the distance the joints would have covered in the time of the jump; a larger deviation from one ordinary step means
# that the clock was not set.
RAN_ON = 0.1


def without_clock_steps(log: Log) -> Log:
    """Return the log with its clock corrected where it was set back or ahead, and faults that report it.

    The clock was set where the joints moved on as in one ordinary step.  Where they did not, another motion begins or
    rows are missing, and the clock is kept.
    """
    steps = steps_of(log)
    if steps is None:
        return log
    jumps = np.flatnonzero(steps.joined & (np.abs(steps.length) > GAP_STEPS * steps.ordinary))
    set_at = [row for row in jumps.tolist() if _ran_on(log, row, steps.ordinary)]
    if not set_at:
        return log
    time, faults = log.time.copy(), []
    for row in set_at:
        wrong = float(steps.length[row]) - steps.ordinary
        time[row + 1 :] -= wrong
        if _told(log, row):
            continue  # rows written twice, dropped by now, account for the time; they are reported already
        way = f"{'ahead' if wrong > 0.0 else 'back'} by {abs(wrong):.4g} s, though the joints went on"
        where = f"{log.time[row]:.6g} s to {log.time[row + 1]:.6g} s"
        faults.append(Fault("data.clock", where, f"it was set {way}: time runs on there"))
    return put_right(log, time, faults)


def _told(log: Log, row: int) -> bool:
    left_out = [span for fault in log.faults for span in fault.spans]
    return any(log.time[row] <= low and high <= log.time[row + 1] for low, high in left_out)


def _ran_on(log: Log, row: int, ordinary: float) -> bool:
    # Whether the joints moved from a row to the next as in one ordinary step, and not for as long as the clock says.
    before, after = np.arange(row - AROUND, row + 1), np.arange(row + 1, row + AROUND + 2)
    if before[0] < 0 or after[-1] >= log.time.size or np.ptp(log.segment[[before[0], after[-1]]]) != 0:
        return False
    off, went, missing = 0.0, 0.0, abs(log.time[row + 1] - log.time[row]) / ordinary
    for joint in log.joints:
        position = log.columns[f"{POSITION}.{joint}"]
        sides = [position[rows] for rows in (before, after)]
        travel, known = min(float(np.ptp(side)) for side in sides), MOVED * _noise(position)
        if travel < known:
            # A joint that rests before or after but has changed position moved in between: this is evidence against a
            # set clock.  A joint that only starts or stops there is no evidence.
            off += max(abs(position[row + 1] - position[row]) - known, 0.0)
            continue
        speed = float(np.mean([side[-1] - side[0] for side in sides])) / AROUND
        off += abs(position[row + 1] - position[row] - speed)
        went += abs(speed) * missing
    return bool(off < RAN_ON * went)


def _noise(position: Floats) -> float:
    # Of a single sample relative to its neighbours.
    return float(np.median(np.abs(np.diff(position, 2))))
