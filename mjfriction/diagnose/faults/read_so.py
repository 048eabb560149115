"""The gap of a log whose columns are read in another way."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace

import numpy as np

from mjfriction.identify.gap import Gap
from mjfriction.identify.measure import measure_gap
from mjfriction.record.fault import Mend
from mjfriction.record.log import POSITION, VELOCITY, Floats, Log
from mjfriction.record.recorded_velocity import velocity_ratio
from mjfriction.record.reread import part_of, reread
from mjfriction.record.span import EVER, Span, within
from mjfriction.robot.bandwidth import HIGHEST
from mjfriction.robot.robot import Robot

AGREES = 2.0  # factor within which a measured velocity agrees with that of its position


def read_so(gap: Gap, mends: Iterable[Mend], robot: Robot, *, highest: float = HIGHEST) -> Gap:
    """Return the gap of a ``robot`` and a log that is read as mends say.

    A measured velocity that agrees with its position as logged is mended in the same way as the position.  ``highest``
    is the upper limit of the position filter's cutoff (Hz).
    """
    log = gap.log
    for mend in mends:
        log = reread(log, _with_velocities(mend, gap))
    return measure_gap(log, robot, highest=highest)


def off_as_stated(readings: Sequence[Gap], span: Span = EVER) -> Floats:
    """Return how far off the stated robot is with each of several readings of a log, within a ``span`` of time.

    It is the logarithm of a product over the joints that all readings examine: of the residual's norm relative to the
    effort's.  With a product, a joint that has a cause of its own does not drown out the others.
    """
    joints = set.intersection(*(set(read.examined) for read in readings))
    off = np.zeros(len(readings))
    for k, read in enumerate(readings):
        own = within(span, read.chain.time)
        for joint in joints:
            clear = own & read.clear[:, joint]
            rows = clear if np.any(clear) else own
            left, effort = (np.linalg.norm(values[rows, joint]) for values in (read.residual, read.measured))
            off[k] += np.log(max(float(left), 1e-300) / max(float(effort), 1e-300))
    return off


def _with_velocities(mend: Mend, gap: Gap) -> Mend:
    log, cutoff = part_of(gap.log, mend.span), gap.motion.cutoff
    factors = [(velocity, factor) for column, factor in mend.factors for velocity in _velocity(column, log, cutoff)]
    pairs = [
        (one, other)
        for columns in mend.exchanged
        for one in _velocity(columns[0], log, cutoff)
        for other in _velocity(columns[1], log, cutoff)
    ]
    return replace(mend, factors=(*mend.factors, *factors), exchanged=(*mend.exchanged, *pairs))


def _velocity(column: str, log: Log, cutoff: float) -> Iterator[str]:
    quantity, _, joint = column.partition(".")
    if quantity == POSITION:
        ratio = velocity_ratio(log, joint, cutoff)
        if ratio is not None and ratio > 0.0 and abs(np.log(ratio)) < np.log(AGREES):
            yield f"{VELOCITY}.{joint}"
