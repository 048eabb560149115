"""Measured velocities that contradict their own positions: they are not used, and that is reported."""

from __future__ import annotations

import numpy as np

from mjfriction.diagnose.faults.units import DEGREE, near
from mjfriction.identify.gap import Gap
from mjfriction.record.fault import Fault
from mjfriction.record.log import VELOCITY
from mjfriction.record.recorded_velocity import velocity_ratio

PER_REVOLUTION_A_MINUTE, THOUSAND = 30.0 / np.pi, 1000.0


def find_velocity_faults(gap: Gap) -> list[Fault]:
    """Return the measured velocities that are the derivative of their position with its sign reversed or in another
    unit: degrees or revolutions per minute, thousandths, or the motor's speed where the robot states a gear.

    The log's positions have to be right: they tell how the joints moved.
    """
    out = []
    for joint, name in enumerate(gap.robot.joints):
        ratio = velocity_ratio(gap.log, name, gap.motion.cutoff)
        if ratio is None or near(ratio, 1.0):
            continue
        unit = "m/s" if gap.body.sliding[joint] else "rad/s"
        gear = abs(gap.robot.table.joint[joint].actuator.gear_ratio)
        units = {
            1.0 / DEGREE: "degrees per second",
            PER_REVOLUTION_A_MINUTE: "revolutions per minute",
            THOUSAND: "thousandths",
            gear: "the motor's speed",
        }
        column = f"{VELOCITY}.{name}"
        of = f"it is {ratio:.4g} times the rate at which its position changes"
        if near(ratio, -1.0):
            out.append(Fault("data.sign", column, f"{of}: turn its sign; it was not used"))
        for factor, words in units.items():
            if near(abs(ratio), factor) and not near(factor, 1.0):
                out.append(Fault("data.unit", column, f"{of}, as {words} are: convert it to {unit}; it was not used"))
                break
    return out
