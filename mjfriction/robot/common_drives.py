"""Drives that two joints turn, stated in a robot."""

from __future__ import annotations

from mjfriction.robot.friction import raised_levels
from mjfriction.robot.robot import Robot
from mjfriction.robot.schema import CommonDrive


def with_common_drive(robot: Robot, joint: str, drive: CommonDrive) -> Robot:
    """Return the robot with one more drive stated at a joint, besides what the joint has of its own."""
    table = robot.joint(joint)
    return robot.with_joint(table.model_copy(update={"common_drive": (*table.common_drive, drive)}))


def with_drive_turned_too(robot: Robot, joint: str, drive: CommonDrive) -> Robot:
    """Return the robot with a drive that is the joint's own, and turns with another joint too: its friction and its
    rotor are no longer stated of the joint, as far as they were.
    """
    lowered = raised_levels(robot, joint, -drive.coulomb, -drive.viscous)
    return with_common_drive(without_rotor(lowered, joint, drive.inertia), joint, drive)


def without_rotor(robot: Robot, joint: str, inertia: float) -> Robot:
    """Return the robot with an inertia (at the joint, kg·m² or kg) taken from what is stated of the joint's rotor, as
    far as any is.
    """
    table = robot.joint(joint)
    rest = max(0.0, table.actuator.rotor_inertia - inertia / table.actuator.gear_ratio**2)
    actuator = table.actuator.model_copy(update={"rotor_inertia": rest})
    return robot.with_joint(table.model_copy(update={"actuator": actuator}))
