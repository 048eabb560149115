"""Positions and clocks that are in the wrong unit."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from mjfriction.body.model import Body
from mjfriction.diagnose.faults.look import HALF, SOME, look_at
from mjfriction.diagnose.faults.read_so import off_as_stated, read_so
from mjfriction.identify.gap import Gap
from mjfriction.record.fault import Fault, Mend
from mjfriction.record.log import POSITION, VELOCITY, Log
from mjfriction.record.motion import Motion
from mjfriction.record.recorded_velocity import velocity_ratio
from mjfriction.record.reread import part_of
from mjfriction.record.span import EVER, Span

DEGREE = np.pi / 180.0
MILLIMETRE = 1e-3
UNDECIDED = 0.05  # difference of the logarithms of two readings' residuals below which they do not decide
AS_ONE = 0.03  # relative difference below which two joints' ratios, or a joint's and a unit's, count as equal
OFF, MOST_OFF = 0.06, 2.0  # relative error above which a clock is reported, and the largest factor it may be off by


def find_units(gap: Gap) -> list[Fault]:
    """Return the positions that are in another unit than radians or metres, in a whole log or in one of several joined
    logs.
    """
    logs = gap.log.logs
    found = [_within(gap, span) for _, span in logs]
    if all([fault.where for fault in own] == [fault.where for fault in found[0]] for own in found):
        return found[0]
    return [alone(fault, name, span) for (name, span), own in zip(logs, found, strict=True) for fault in own]


def alone(fault: Fault, name: str, span: Span) -> Fault:
    """Return a fault restricted to one of several joined logs."""
    mend = None if fault.mend is None else replace(fault.mend, span=span)
    return replace(fault, where=f"{fault.where}, in {name} alone", mend=mend)


def _within(gap: Gap, span: Span) -> list[Fault]:
    log = part_of(gap.log, span)
    known = find_unit_faults(log, gap.body) or find_degrees_by_velocity(log, gap.body, gap.motion.cutoff)
    return _with_silent(gap, known or find_degrees(gap, span), span)


def _with_silent(gap: Gap, faults: list[Fault], span: Span) -> list[Fault]:
    # A joint that is held, or hardly moves, does not reveal its unit.  Where others are in degrees, it may be too.  Its
    # position changes the loads on the others, which decide; if they do not, it is read as most joints are.
    body = gap.body
    columns = [f"{POSITION}.{joint}" for joint, slides in zip(body.joints, body.sliding, strict=True) if not slides]
    told = {column for fault in faults if fault.mend for column, factor in fault.mend.factors if factor == DEGREE}
    silent = [column.partition(".")[2] for column in columns if column not in told]
    if not told or not silent:
        return faults
    action = "it hardly tells its unit, and others are in degrees; convert it to radians"
    more = [*faults, *(in_another_unit(joint, DEGREE, action) for joint in silent)]
    mends = [[replace(fault.mend, span=span) for fault in own if fault.mend] for own in (faults, more)]
    apart = off_as_stated([read_so(gap, own, gap.robot, highest=gap.motion.cutoff) for own in mends], span)
    difference = float(apart[1] - apart[0])
    return more if difference < (UNDECIDED if len(told) > len(silent) else -UNDECIDED) else faults


def find_unit_faults(log: Log, body: Body) -> list[Fault]:
    """Return the positions that lie so far outside a joint's limits that they must be in another unit.

    Degrees read as radians, or millimetres as metres, exceed the limits by more than the whole range between them.
    """
    out = []
    for i, joint in enumerate(body.joints):
        values = log.channel(POSITION, joint)
        span = body.upper[i] - body.lower[i]
        if values is None or not np.isfinite(span) or span <= 0.0:
            continue
        low, high = float(np.min(values)), float(np.max(values))
        if low < body.lower[i] - span or high > body.upper[i] + span:
            unit, other = ("m", "millimetres") if body.sliding[i] else ("rad", "degrees")
            action = (
                f"it runs from {low:.4g} to {high:.4g} {unit}, where the model's limits are {body.lower[i]:.4g} to "
                f"{body.upper[i]:.4g} {unit}; convert it if it is in {other}"
            )
            out.append(in_another_unit(joint, MILLIMETRE if body.sliding[i] else DEGREE, action))
    return out


def find_degrees_by_velocity(log: Log, body: Body, cutoff: float) -> list[Fault]:
    """Return the positions of turning joints that change 57.3 times as fast as measured velocities say, both compared
    well below the position filter's ``cutoff`` (Hz).
    """
    turning = [joint for joint, sliding in zip(body.joints, body.sliding, strict=True) if not sliding]
    ratios = _velocity_ratios(log, cutoff, turning)
    action = f"it changes {1.0 / DEGREE:.1f} times as fast as {VELOCITY} says; convert it from degrees to radians"
    return [in_another_unit(joint, DEGREE, action) for joint, ratio in ratios.items() if near(ratio, DEGREE)]


def in_another_unit(joint: str, factor: float, action: str) -> Fault:
    """Return the fault of a joint's position that has to be multiplied by a factor."""
    column = f"{POSITION}.{joint}"
    return Fault("data.unit", column, action, mend=Mend(factors=((column, factor),)))


def stretched_clock(log: Log, motion: Motion) -> float | None:
    """Return the factor between measured velocities and those of the positions on the log's clock, if it is the same at
    two joints or more and may be the error of a clock; None otherwise.

    A velocity that is itself in another unit, or measured on the motor's side, is off by more than a clock may be.
    """
    ratios = list(_velocity_ratios(log, motion.cutoff, motion.joints).values())
    middle = float(np.median(ratios)) if len(ratios) > 1 else 1.0
    off = abs(middle - 1.0) > OFF and 1.0 / MOST_OFF < middle < MOST_OFF
    return middle if off and all(near(ratio, middle) for ratio in ratios) else None


def _velocity_ratios(log: Log, cutoff: float, joints: Sequence[str]) -> dict[str, float]:
    found = {joint: velocity_ratio(log, joint, cutoff) for joint in joints}
    return {joint: ratio for joint, ratio in found.items() if ratio is not None and ratio > 0.0}


def near(ratio: float, other: float) -> bool:
    """Return whether a ratio is another one up to what measured velocities are off by."""
    return abs(ratio / other - 1.0) < AS_ONE


def find_degrees(gap: Gap, span: Span = EVER) -> list[Fault]:
    """Return the positions of all turning joints, if any of them exceeds a turn within a ``span`` of time and the
    efforts fit once these positions are read as degrees.
    """
    turning = ~np.array(gap.body.sliding)
    look = look_at(gap, span)
    if not np.any(np.abs(look.course[0][:, turning]) > 2.0 * np.pi):
        return []
    as_logged = look.left_as_logged
    as_degrees = look.left([values * np.where(turning, DEGREE, 1.0) for values in look.course], look.effort)
    if not np.any(as_logged > SOME) or np.sum(as_degrees) > HALF * np.sum(as_logged):
        return []
    names = [joint for joint, turns in zip(gap.robot.joints, turning, strict=True) if turns]
    action = "the efforts fit if it is in degrees; convert it to radians"
    return [in_another_unit(joint, DEGREE, action) for joint in names]
