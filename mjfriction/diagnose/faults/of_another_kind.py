"""A sliding joint's columns in a turning joint's place: its positions exceed the limits but are in no other unit."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mjfriction.diagnose.faults.misplaced import CLEARLY, EXCHANGE, EXCHANGE_JOINTS, effort_column, position_column
from mjfriction.diagnose.faults.read_so import off_as_stated, read_so
from mjfriction.errors import LogError
from mjfriction.identify.gap import Gap
from mjfriction.record.fault import Fault, Mend

MENDED = 0.3  # fraction of what is left that each of the two may keep, on (geometric) average, once exchanged


def of_another_kind(gap: Gap, faults: Sequence[Fault]) -> list[Fault]:
    """Return the exchange of a sliding joint with a turning one that is behind a unit fault of the sliding one's
    position among ``faults``: of all their columns, or of positions alone.

    The list is empty unless the stated robot fits clearly better with one exchange than with any other, and than with
    the log as it is.
    """
    slides = gap.body.sliding
    where = {fault.where for fault in faults if fault.kind == "data.unit"}
    beyond = [joint for joint in gap.examined if slides[joint] and position_column(gap, joint) in where]
    # A turning joint that reads a slide's positions hardly moves in them, and may not be examined for that reason.
    turning = [joint for joint, slide in enumerate(slides) if not slide]
    if len(beyond) != 1 or not turning:
        return []
    tried = [fault for other in turning for fault in _exchanges(gap, beyond[0], other)]
    readings = []
    for fault in tried:
        try:
            readings.append(read_so(gap, [fault.mend] if fault.mend else [], gap.robot, highest=gap.motion.cutoff))
        except LogError:
            readings.append(gap)  # nothing moves when read this way: it counts as no better than logged
    *off, as_logged = off_as_stated([*readings, gap])
    least, *others = np.argsort(off).tolist()
    clearly = all(off[least] < off[other] + np.log(CLEARLY) for other in others)
    return [tried[least]] if clearly and off[least] < as_logged + 2.0 * np.log(MENDED) else []


def _exchanges(gap: Gap, one: int, other: int) -> list[Fault]:
    columns = [(name(gap, one), name(gap, other)) for name in (position_column, effort_column)]
    names = gap.robot.joints[one], gap.robot.joints[other]
    positions = Fault(
        "data.swap", f"{columns[0][0]} and that of {names[1]}", EXCHANGE, mend=Mend(exchanged=(columns[0],))
    )
    if gap.motion.quantity[other] is None:
        return [positions]
    where = f"all columns of {names[0]} and {names[1]}"
    return [positions, Fault("data.swap", where, EXCHANGE_JOINTS, mend=Mend(exchanged=tuple(columns)))]
