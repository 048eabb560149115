"""How drives move a robot's MuJoCo model along a measured motion, so that it goes as the robot says the machine does.

A model file holds links, rotors, springs and friction laws.  What a robot states besides (cogging, couplings, levels
that change with time, what transmissions give, late and scaled sensors) is no part of it, but known along the motion.
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
    """What drives a model along a motion, ``torque`` (N·m or N), NaN where a drive reported nothing; and where its
    links are by what the sensors read, ``position`` and ``velocity``; each (n, joints).
    """

    torque: Floats
    position: Floats
    velocity: Floats


def drive_model(robot: Robot, motion: Motion) -> Driven:
    """Return how a robot's model is driven along a motion: by what its drives gave, less what it states besides.

    With τ̂ the balance of the whole robot along the motion and τ̂ₘ that of its model alone along its links' motion, the
    torque is given − τ̂ + τ̂ₘ.  What a low-pass has taken of a report stays away: a model that falls for a moment does
    not feel it.
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
    # A model in MuJoCo is at room temperature, and holds nothing that the log says was held.  That friction turns where
    # the motor does is left to the model: the moments between that and where the link turns are in doubt.
    links, rubbing = (replace(one, columns={}) for one in (carried.linked, carried.rubbing))
    alone = effort_of(plain, links, replace(carry(plain, body, links), rubbing=rubbing))
    torque = given - effort_of(whole, motion, carried).total + alone.total
    return Driven(np.asarray(torque), carried.linked.position, carried.linked.velocity)


def _at_zero(robot: Robot) -> Robot:
    for joint in robot.table.joint:
        robot = robot.with_joint(joint.model_copy(update={"position_sensor": PositionSensor()}))
    return robot


def _read_beside(motion: Motion) -> bool:
    # Whether the log has columns that links or friction may be read by.
    return any(name == HELD_MASS or name.partition(".")[0] in AROUND for name in motion.columns)
