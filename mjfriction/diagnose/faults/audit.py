"""Faults of a log that would otherwise be blamed on physics."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable

import numpy as np

from mjfriction.diagnose.faults.look import FEWEST_ROWS, look_at
from mjfriction.diagnose.faults.misplaced import effort_column, find_misplaced, of_efforts_or_positions
from mjfriction.diagnose.faults.units import alone, find_units, stretched_clock
from mjfriction.identify.gap import Gap
from mjfriction.record.fault import Fault, Mend
from mjfriction.record.log import EFFORT, Floats
from mjfriction.record.runs import Mask
from mjfriction.record.span import EVER, Span, within

ALIKE = 0.9  # correlation above which an effort is taken to match a prediction
UNLIKE = 0.6  # correlation below which it is taken not to match
MOST_OFF = 5.0  # largest factor, up or down, by which a drive constant may be off
THOUSAND = 1000.0
AS_KNOWN = 1.25  # largest factor, up or down, by which an effort's scale may deviate from that of a known unit


def find_faults(gap: Gap) -> list[Fault]:
    """Compare every joint's effort with what the robot says it needs, and return faults that no physics explains.

    Positions beyond what limits, measured velocities or efforts allow are in the wrong unit, and a clock may run too
    fast or too slow. An effort has a fault of sign, unit or wiring where it clearly matches the prediction with its
    sign reversed or many times too large or small, or where it matches another joint's prediction while that joint's
    effort matches this one's. Last come columns with a reversed sign or in another joint's place. With several logs,
    the last two checks are repeated on each log alone.
    """
    return (
        find_units(gap)
        or find_stretched(gap)
        or find_misread(gap)
        or find_misplaced(gap)
        or _in_one_log(gap, find_misread)
        or _in_one_log(gap, find_misplaced)
    )


def _in_one_log(gap: Gap, find: Callable[[Gap, Span], list[Fault]]) -> list[Fault]:
    # A fault in only one of several logs is drowned out by what all of them say together.
    logs = gap.log.logs
    return [alone(fault, name, span) for name, span in logs for fault in find(gap, span)] if len(logs) > 1 else []


def find_stretched(gap: Gap) -> list[Fault]:
    """Return the fault of a clock that runs too fast or too slow.

    It is reported where measured velocities indicate it and the efforts fit no worse with the clock corrected.
    Otherwise the velocities are wrong, and they are not used.
    """
    factor = stretched_clock(gap.log, gap.motion)
    if factor is None:
        return []
    look = look_at(gap)
    position, velocity, acceleration = look.course
    mended = look.left([position, factor * velocity, factor**2 * acceleration], look.effort)
    if np.sum(mended) > np.sum(look.left_as_logged):
        return []
    action = (
        f"measured velocities are {factor:.3g} times what positions do on this clock, and the efforts fit if it is at "
        f"fault: {'stretch' if factor < 1.0 else 'shorten'} time by {1.0 / factor:.3g}, or leave the velocities out"
    )
    return [Fault("data.clock", "whole log", action)]


def find_misread(gap: Gap, span: Span = EVER) -> list[Fault]:
    """Return the effort columns that do not match their own prediction within a ``span`` of time.

    They match it with the sign reversed or the scale wrong, or match that of another joint.
    """
    examined = list(gap.examined)
    own = within(span, gap.chain.time)
    clear = gap.clear[own]
    if not np.any(clear):
        return []
    predicted = gap.chain.rows(gap.effort.reported)[own][:, examined]
    measured = gap.measured[own][:, examined]
    measured, predicted = (values - np.mean(values, axis=0) for values in (measured, predicted))
    size = np.sqrt(np.outer(np.sum(np.square(measured), axis=0), np.sum(np.square(predicted), axis=0)))
    likeness = np.divide(measured.T @ predicted, size, out=np.zeros_like(size), where=size > 0.0)
    faults, of_size = [], dict[int, Fault]()
    for i, joint in enumerate(examined):
        if np.count_nonzero(clear[:, joint]) < FEWEST_ROWS:
            continue
        # At rest friction may take any value, and a pick-and-place log is mostly rest: use clear rows only.
        alike, factor = _likeness(*(rows[clear[:, joint], i] for rows in (measured, predicted)))
        for j in range(i):
            crossed = min(likeness[i, j], likeness[j, i])
            if crossed > ALIKE and max(likeness[i, i], likeness[j, j]) < UNLIKE:
                faults.append(of_efforts_or_positions(gap, span, joint, examined[j]))
        if alike < -ALIKE and 1.0 / MOST_OFF < factor < MOST_OFF:
            faults.append(of_efforts_or_positions(gap, span, joint, None))
        elif abs(alike) > ALIKE and not 1.0 / MOST_OFF < factor < MOST_OFF:
            action = f"it reads {factor:.3g} times what the robot needs; convert it to N·m or N at the joint, or A"
            mend = _in_a_known_unit(gap, joint, math.copysign(factor, alike))
            of_size[i] = Fault("data.unit", effort_column(gap, joint), action, mend=mend)
    # Two efforts that have the wrong scale for their own joints, but the right one for each other's, are exchanged.
    for i, j in itertools.combinations(of_size, 2):
        if i in of_size and j in of_size and _of_each_other(gap, own, (i, j)):
            faults.append(of_efforts_or_positions(gap, span, examined[j], examined[i]))
            del of_size[i], of_size[j]
    return [*faults, *of_size.values()]


def _of_each_other(gap: Gap, own: Mask, pair: tuple[int, int]) -> bool:
    # Whether each of two examined joints reports what the stated robot would report at the other one.
    for i, j in (pair, pair[::-1]):
        one, other = gap.examined[i], gap.examined[j]
        rows = own & gap.clear[:, one]
        read = gap.measured[rows, other] / gap.per_reported[other]
        needed = gap.chain.rows(gap.effort.reported)[rows, one] / gap.per_reported[one]
        alike, factor = _likeness(read, needed)
        if not (alike > ALIKE and 1.0 / MOST_OFF < factor < MOST_OFF):
            return False
    return True


def _in_a_known_unit(gap: Gap, joint: int, factor: float) -> Mend | None:
    # The mend of an effort that is off by a known factor: 1000 or its inverse, or a conversion that the robot file
    # states. None where no known factor, or more than one, is near.
    drive = gap.robot.table.joint[joint].actuator
    known = {THOUSAND, 1.0 / THOUSAND}
    if gap.motion.quantity[joint] == EFFORT:
        known |= {1.0 / worth for worth in (drive.gear_ratio, drive.effort_per_ampere) if worth}
    near = [one for one in known if factor / one > 0.0 and abs(math.log(factor / one)) < math.log(AS_KNOWN)]
    return Mend(factors=((effort_column(gap, joint), 1.0 / near[0]),)) if len(near) == 1 else None


def _likeness(measured: Floats, predicted: Floats) -> tuple[float, float]:
    # The correlation of two series (rows,), and the ratio of the first one's standard deviation to the second's.
    a, b = (values - np.mean(values) for values in (measured, predicted))
    size = float(np.sqrt((a @ a) * (b @ b)))
    return (float(a @ b) / size if size > 0.0 else 0.0), float(np.sqrt((a @ a) / max(float(b @ b), 1e-300)))
