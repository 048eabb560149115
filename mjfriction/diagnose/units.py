"""Positions and clocks in a unit they should not be in."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mjfriction.body.model import Body
from mjfriction.record.faults import Fault, Mend
from mjfriction.record.log import POSITION, VELOCITY, Log
from mjfriction.record.motion import Motion, velocity_ratio

DEGREE = np.pi / 180.0
MILLIMETRE = 1e-3
AS_ONE = 0.03  # by which joints' ratios may differ from each other, or from that of a unit, and be one
OFF, MOST_OFF = 0.06, 2.0  # by which a clock is off that is worth a word, and the factor it is off by at most


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
            out.append(in_another_unit(joint, MILLIMETRE if body.sliding[i] else DEGREE, action))
    return out


def find_degrees_by_velocity(log: Log, body: Body, motion: Motion) -> list[Fault]:
    """Return the positions of turning joints that change 57.3 times as fast as measured velocities say."""
    turning = [joint for joint, sliding in zip(body.joints, body.sliding, strict=True) if not sliding]
    ratios = _velocity_ratios(log, motion, turning)
    action = f"it changes {1.0 / DEGREE:.1f} times as fast as {VELOCITY} says; convert it from degrees to radians"
    return [in_another_unit(joint, DEGREE, action) for joint, ratio in ratios.items() if _near(ratio, DEGREE)]


def in_another_unit(joint: str, factor: float, action: str) -> Fault:
    """Return the fault of a joint's position that has to be taken times a factor."""
    column = f"{POSITION}.{joint}"
    return Fault("data.unit", column, action, mend=Mend(factors=((column, factor),)))


def stretched_clock(log: Log, motion: Motion) -> float | None:
    """Return by what measured velocities are off from those of positions on the log's clock, where that is one factor
    at two joints or more, and one that a clock may be off by; None where it is not.

    A velocity that is itself in another unit, or on the motor's side, is off by more.
    """
    ratios = list(_velocity_ratios(log, motion, motion.joints).values())
    middle = float(np.median(ratios)) if len(ratios) > 1 else 1.0
    off = abs(middle - 1.0) > OFF and 1.0 / MOST_OFF < middle < MOST_OFF
    return middle if off and all(_near(ratio, middle) for ratio in ratios) else None


def _velocity_ratios(log: Log, motion: Motion, joints: Sequence[str]) -> dict[str, float]:
    found = {joint: velocity_ratio(log, joint, motion.cutoff, motion.clock) for joint in joints}
    return {joint: ratio for joint, ratio in found.items() if ratio is not None}


def _near(ratio: float, other: float) -> bool:
    return abs(ratio / other - 1.0) < AS_ONE
