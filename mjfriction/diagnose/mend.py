"""A log at fault, read as it should have been where that is sure."""

from __future__ import annotations

from dataclasses import dataclass, replace

from mjfriction.diagnose.audit import find_faults
from mjfriction.diagnose.look import look_at
from mjfriction.diagnose.misplaced import NO_WORSE
from mjfriction.diagnose.read_so import read_so
from mjfriction.identify.gap import Gap, measure_gap
from mjfriction.record.faults import Fault
from mjfriction.record.log import Log
from mjfriction.robot.bandwidth import HIGHEST
from mjfriction.robot.robot import Robot

MOST_ROUNDS = 3  # of looking for faults beside those that are mended


@dataclass(frozen=True)
class Audited:
    """The ``gap`` of a log as it should have been read, and its ``faults``; where one of them has no sure mend the log
    is ``refused``, and the gap is of the log as it is.
    """

    gap: Gap
    faults: tuple[Fault, ...]
    refused: bool


def audited(log: Log, robot: Robot, *, highest: float = HIGHEST) -> Audited:
    """Hold a log against a robot, look for faults, mend those that say how, and look again.

    ``highest`` is the most that the position filter's cutoff may be (Hz).  A log is mended if nothing is found in it
    then, and the efforts fit no worse at any joint.  Raises what
    :func:`~mjfriction.identify.gap.measure_gap` does.
    """
    stated = measure_gap(log, robot, highest=highest)
    gap, told = stated, list[Fault]()
    for _ in range(MOST_ROUNDS):
        faults = find_faults(gap)
        if not faults:
            done = (replace(fault, action=f"{fault.action} (read so here)") for fault in told)
            return Audited(gap, tuple(done), refused=False)
        told += faults
        mends = [fault.mend for fault in faults if fault.mend is not None]
        if len(mends) < len(faults):
            break
        mended = read_so(gap, mends, robot, highest=highest)
        if not _fits_no_worse(mended, gap):
            break
        gap = mended
    return Audited(stated, tuple(told), refused=True)


def _fits_no_worse(mended: Gap, gap: Gap) -> bool:
    # Joints that are examined either way: of one in another unit it may be unknown whether it moves.
    left = [dict(zip(one.examined, look_at(one).left_as_logged, strict=True)) for one in (mended, gap)]
    both = left[0].keys() & left[1].keys()
    return bool(both) and all(left[0][joint] < left[1][joint] + NO_WORSE for joint in both)
