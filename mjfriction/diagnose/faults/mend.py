"""Find the faults of a log and read it as it should have been, where that is certain."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from mjfriction.diagnose.faults.audit import find_faults
from mjfriction.diagnose.faults.look import NO_WORSE, look_at
from mjfriction.diagnose.faults.misplaced import effort_column
from mjfriction.diagnose.faults.of_another_kind import of_another_kind
from mjfriction.diagnose.faults.read_so import off_as_stated, read_so
from mjfriction.diagnose.faults.velocities import find_velocity_faults
from mjfriction.errors import LogError
from mjfriction.identify.gap import Gap
from mjfriction.identify.measure import measure_gap
from mjfriction.record.fault import Fault, Mend
from mjfriction.record.log import POSITION, Log
from mjfriction.robot.bandwidth import HIGHEST
from mjfriction.robot.robot import Robot

MOST_ROUNDS = 3  # rounds of mending: a mended log may show further faults
# Positions in another unit are also read with that unit divided and multiplied by ANOTHER_SIZE.  The logarithms of what
# these two readings leave must together exceed twice the unit's own by more than TOLD, and the minimum of their
# parabola must lie within NEAR (relative) of the unit.
ANOTHER_SIZE, TOLD, NEAR = 1.25, 0.05, 0.1


@dataclass(frozen=True)
class Audited:
    """A log checked for ``faults``: ``gap`` is of the log as it should have been read, ``stated`` of the log as it is.

    If one of the faults cannot be mended with certainty, the log is ``refused`` and both gaps are the same.  ``unused``
    are faults of columns that the diagnosis does without.
    """

    stated: Gap
    gap: Gap
    faults: tuple[Fault, ...]
    refused: bool
    unused: tuple[Fault, ...] = ()

    @property
    def moved_otherwise(self) -> bool:
        """Whether positions were misread: the machine's joints would then not move as a motion plan says."""
        columns = [name for fault in self.faults if fault.mend for name in _columns(fault.mend)]
        return any(name.startswith(POSITION) for name in columns)


def audited(log: Log, robot: Robot, *, highest: float = HIGHEST) -> Audited:
    """Compare a log with a robot, look for faults, mend them where they say how, and look again.

    ``highest`` is the upper limit of the position filter's cutoff (Hz).  Raises what
    :func:`~mjfriction.identify.measure.measure_gap` does.
    """
    stated = measure_gap(log, robot, highest=highest)
    gap, rounds = stated, list[list[Fault]]()
    while faults := find_faults(gap):
        rounds.append(faults)
        mended = _mended(gap, faults, robot, highest) if len(rounds) <= MOST_ROUNDS else None
        if mended is None and (instead := of_another_kind(gap, faults)):
            mended = _mended(gap, instead, robot, highest)
            rounds[-1] = faults if mended is None else instead  # an exchange that mends nothing is none
        if mended is None:
            # Later rounds found their faults on a log that was mended wrongly.  Only those of the first are the log's.
            return Audited(stated, stated, tuple(rounds[0]), refused=True)
        gap = mended
    told = [replace(fault, action=f"{fault.action} (read so here)") for faults in rounds for fault in faults]
    return Audited(stated, gap, tuple(told), refused=False, unused=tuple(find_velocity_faults(gap)))


def _mended(gap: Gap, faults: Sequence[Fault], robot: Robot, highest: float) -> Gap | None:
    # The gap of the log with its faults mended; None unless it is certain that these were the faults.
    mends = [fault.mend for fault in faults if fault.mend is not None]
    if len(mends) < len(faults):
        return None
    try:
        mended = read_so(gap, mends, robot, highest=highest)
        none_lost = set(gap.examined) <= set(mended.examined)
        sure = none_lost and _fits_no_worse(mended, gap, mends) and _of_their_size(gap, mends, mended)
    except LogError:
        return None  # nothing moves, or too fast for any filter to follow: the log cannot be read this way
    return mended if sure else None


def _fits_no_worse(mended: Gap, gap: Gap, mends: Sequence[Mend]) -> bool:
    # An exchanged effort column is compared with how well it was explained at the joint where it stood before.
    after, before = (dict(zip(one.examined, look_at(one).left_as_logged, strict=True)) for one in (mended, gap))
    stood = {joint: joint for joint in before}
    columns = {effort_column(gap, joint): joint for joint in before}
    for one, other in (pair for mend in mends for pair in mend.exchanged):
        if one in columns and other in columns:
            stood[columns[one]], stood[columns[other]] = columns[other], columns[one]
    return all(after[joint] < before[stood[joint]] + NO_WORSE for joint in before)


def _of_their_size(gap: Gap, mends: Sequence[Mend], mended: Gap) -> bool:
    # Joint limits only show that positions are in another unit.  The efforts must show that it is this one: the minimum
    # of a parabola through what is left with it, and with units a quarter larger and smaller, must be near.
    scaled = [
        mend for mend in mends if any(name.startswith(POSITION) and abs(own) != 1.0 for name, own in mend.factors)
    ]
    if not scaled:
        return True
    readings = [mended]
    for size in (1.0 / ANOTHER_SIZE, ANOTHER_SIZE):
        resized = [
            replace(mend, factors=tuple((name, size * own) for name, own in mend.factors)) if mend in scaled else mend
            for mend in mends
        ]
        readings.append(read_so(gap, resized, mended.robot, highest=mended.motion.cutoff))
    own, less, more = off_as_stated(readings)
    bend = less + more - 2.0 * own
    lowest = 0.5 * np.log(ANOTHER_SIZE) * (less - more) / bend if bend > TOLD else np.inf
    return bool(abs(lowest) < NEAR)


def _columns(mend: Mend) -> list[str]:
    return [*(name for name, _ in mend.factors), *(name for pair in mend.exchanged for name in pair)]
