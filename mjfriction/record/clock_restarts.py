"""A clock that starts again with each segment, as episodes recorded one by one have it."""

from __future__ import annotations

import numpy as np

from mjfriction.record.clock import put_right
from mjfriction.record.fault import Fault, moment
from mjfriction.record.log import Log

PAUSE = 1.0  # s between two motions that were recorded apart


def with_running_clock(log: Log) -> Log:
    """Return the log with time that increases throughout, and a fault that says where it did not.

    Where a segment begins no later than the one before it ended, it and all that follow are moved to begin one
    :data:`PAUSE` after that end.  Within a segment nothing is changed.
    """
    back = np.flatnonzero((np.diff(log.time) <= 0.0) & (np.diff(log.segment) != 0)) + 1
    if not back.size:
        return log
    time = log.time.copy()
    for row in back.tolist():
        time[row:] += time[row - 1] + PAUSE - time[row]
    numbers = ", ".join(str(number) for number in log.segment[back[:3]]) + (", …" if back.size > 3 else "")
    where = f"segment{'s' if back.size > 1 else ''} {numbers}"
    first = f"segment {log.segment[back[0]]} begins at {moment(float(time[back[0]]))} s"
    return put_right(log, time, [Fault("data.clock", where, f"the clock starts again: counted on, so that {first}")])
