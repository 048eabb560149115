"""The gap of a log whose columns are read another way."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np

from mjfriction.identify.gap import Gap, measure_gap
from mjfriction.record.faults import Mend
from mjfriction.record.log import POSITION, VELOCITY
from mjfriction.record.motion import velocity_ratio
from mjfriction.record.reread import reread
from mjfriction.robot.bandwidth import HIGHEST
from mjfriction.robot.robot import Robot

AGREES = 2.0  # times, by which a measured velocity may be off from its position's and be one with it


def read_so(gap: Gap, mends: Iterable[Mend], robot: Robot, *, highest: float = HIGHEST) -> Gap:
    """Return the gap of a ``robot`` and a log that is read as mends say.

    Velocities that are one with the positions as they were logged are read as these are.  ``highest`` is the most that
    the position filter's cutoff may be (Hz).
    """
    log = gap.log
    for mend in mends:
        log = reread(log, _with_velocities(mend, gap))
    return measure_gap(log, robot, highest=highest)


def _with_velocities(mend: Mend, gap: Gap) -> Mend:
    factors = [(velocity, factor) for column, factor in mend.factors for velocity in _velocity(column, gap)]
    pairs = [
        (one, other)
        for columns in mend.exchanged
        for one in _velocity(columns[0], gap)
        for other in _velocity(columns[1], gap)
    ]
    return replace(mend, factors=(*mend.factors, *factors), exchanged=(*mend.exchanged, *pairs))


def _velocity(column: str, gap: Gap) -> Iterator[str]:
    quantity, _, joint = column.partition(".")
    if quantity == POSITION:
        ratio = velocity_ratio(gap.log, joint, gap.motion.cutoff, gap.motion.clock)
        if ratio is not None and abs(np.log(ratio)) < np.log(AGREES):
            yield f"{VELOCITY}.{joint}"
