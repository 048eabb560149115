"""Drive torques that make a robot's MuJoCo model move along a measured motion as the robot file says the machine does.

The MuJoCo model contains links, rotors, springs and friction laws.  The robot file states more: cogging, couplings,
levels that change with time, deflection of transmissions, delayed and scaled sensors.  These are not in the model, but
their effect is known along the measured motion.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from mjfriction.laws.law import Floats
from mjfriction.record.log import HEAD_PRESSURE, HELD_MASS, ROD_PRESSURE, TEMPERATURE
from mjfriction.record.motion import Motion
from mjfriction.robot.effort import (
    as_given,
    carry,
    effort_of,
    effort_per_reported,
    unheard,
    without_offsets,
)
from mjfriction.robot.robot import Robot
from mjfriction.robot.schema import PositionSensor
from mjfriction.robot.simulation import in_model

AROUND = (TEMPERATURE, HEAD_PRESSURE, ROD_PRESSURE)


@dataclass(frozen=True)
class Driven:
    """What drives a model along a motion, each (n, joints).

    ``torque`` (N·m or N) is NaN where a drive reported nothing.  ``position`` and ``velocity`` are those of the links
    according to the sensors' readings.
    """

    torque: Floats
    position: Floats
    velocity: Floats


def drive_model(robot: Robot, motion: Motion) -> Driven:
    """Return the torques that drive a robot's model along a motion: what its drives gave, less what the model omits.

    τ̂ is the predicted effort of the whole robot along the motion, and τ̂ₘ is that of the MuJoCo model alone along the
    links' motion.  The torque is given − τ̂ + τ̂ₘ.  What a sensor's low-pass has removed from the report is not
    restored: a model that runs freely for a short time is not affected by it.
    """
    pairs = zip(robot.table.joint, motion.quantity, strict=True)
    worth = np.array([effort_per_reported(joint, quantity, robot.name) for joint, quantity in pairs])
    reported, motor = motion.torque * worth, without_offsets(robot, motion)
    drives = zip(robot.table.joint, reported.T, motor.position.T, strict=True)
    given = np.column_stack([as_given(joint, own, motion, at) for joint, own, at in drives])
    plain = in_model(robot)
    if unheard(_at_zero(robot)) == plain and not _read_beside(motion):
        return Driven(given, motor.position, motor.velocity)
    body = robot.body()
    whole, plain = (one.with_stated_friction(body) for one in (robot, plain))
    carried = carry(whole, body, motion)
    # The MuJoCo model is at room temperature and holds none of the mass that the log reports as held, so its motion has
    # no columns.  Both predictions take friction at the same motion (``rubbing``), so the torque does not correct for
    # friction that reverses with the motor, while the model's reverses with the link: between the two reversals the
    # samples are in doubt anyway.
    links, rubbing = (replace(one, columns={}) for one in (carried.linked, carried.rubbing))
    alone = effort_of(plain, links, replace(carry(plain, body, links), rubbing=rubbing))
    torque = given - effort_of(whole, motion, carried).total + alone.total
    return Driven(np.asarray(torque), carried.linked.position, carried.linked.velocity)


def _at_zero(robot: Robot) -> Robot:
    for joint in robot.table.joint:
        robot = robot.with_joint(joint.model_copy(update={"position_sensor": PositionSensor()}))
    return robot


def _read_beside(motion: Motion) -> bool:
    # Whether the log has columns that the torques of links or friction may depend on.
    return any(name == HELD_MASS or name.partition(".")[0] in AROUND for name in motion.columns)
