"""Positions and clocks in a unit they should not be in."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from mjfriction.body.model import Body
from mjfriction.record.faults import Fault
from mjfriction.record.log import POSITION, VELOCITY, Log
from mjfriction.record.motion import Motion, velocity_ratio

DEGREE = np.pi / 180.0
PER_MINUTE = 30.0 / np.pi  # turns per minute in a radian per second
AS_ONE = 0.03  # by which joints' ratios may differ from each other, or from that of a unit, and be one
OFF = 0.06  # by which a clock is off that is worth a word


def find_unit_faults(log: Log, body: Body) -> list[Fault]:
    """Return the positions that lie so far outside a joint's limits that their unit must be another.

    Degrees for radians, or millimetres for metres, leave the limits by more than the whole range between them.
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
            out.append(Fault("data.unit", f"position.{joint}", action))
    return out


def find_rate_faults(log: Log, body: Body, motion: Motion) -> list[Fault]:
    """Return what is wrong with positions or the clock where measured velocities are alike but many times other ones.

    A velocity that is 1/57.3 of its position's rate means degrees; where all joints' are off by one factor that is no
    unit's, the clock is.  A velocity that is itself in another unit is not used, and no fault of the log.
    """
    turning = [joint for joint, sliding in zip(body.joints, body.sliding, strict=True) if not sliding]
    found = {joint: velocity_ratio(log, joint, motion.cutoff, motion.clock) for joint in body.joints}
    ratios = {joint: ratio for joint, ratio in found.items() if ratio is not None}
    degrees = [joint for joint in turning if joint in ratios and _near(ratios[joint], DEGREE)]
    if degrees:
        action = f"it changes {1.0 / DEGREE:.1f} times as fast as {VELOCITY} says; convert it from degrees to radians"
        return [Fault("data.unit", f"{POSITION}.{joint}", action) for joint in degrees]
    return _clock_faults(ratios)


def _clock_faults(ratios: Mapping[str, float]) -> list[Fault]:
    if len(ratios) < 2:
        return []
    middle = float(np.median(list(ratios.values())))
    units = (1.0 / DEGREE, PER_MINUTE, 1.0 / PER_MINUTE)
    if abs(middle - 1.0) < OFF or any(_near(middle, unit) for unit in units):
        return []
    if not all(_near(ratio, middle) for ratio in ratios.values()):
        return []
    action = (
        f"measured velocities are {middle:.3g} times what positions do on this clock; if they are right, "
        f"{'stretch' if middle < 1.0 else 'shorten'} time by {1.0 / middle:.3g}, else leave them out"
    )
    return [Fault("data.clock", "whole log", action)]


def _near(ratio: float, other: float) -> bool:
    return abs(ratio / other - 1.0) < AS_ONE
