"""Change the drives that a robot file states as shared by two joints."""

from __future__ import annotations

from mjfriction.robot.friction import raised_levels
from mjfriction.robot.robot import Robot
from mjfriction.robot.schema import CommonDrive


def with_common_drive(robot: Robot, joint: str, drive: CommonDrive) -> Robot:
    """Return the robot with one more shared drive stated at a joint, in addition to what the joint already has."""
    table = robot.joint(joint)
    return robot.with_joint(table.model_copy(update={"common_drive": (*table.common_drive, drive)}))


def with_drive_turned_too(robot: Robot, joint: str, drive: CommonDrive) -> Robot:
    """Return the robot with the joint's own drive restated as one that turns with another joint too.

    The drive's friction and rotor inertia are subtracted from what is stated for the joint itself, down to 0.
    """
    lowered = raised_levels(robot, joint, -drive.coulomb, -drive.viscous)
    return with_common_drive(without_rotor(lowered, joint, drive.inertia), joint, drive)


def without_rotor(robot: Robot, joint: str, inertia: float) -> Robot:
    """Return the robot with ``inertia`` (at the joint, kg·m² or kg) subtracted from the joint's rotor, down to 0."""
    table = robot.joint(joint)
    rest = max(0.0, table.actuator.rotor_inertia - inertia / table.actuator.gear_ratio**2)
    actuator = table.actuator.model_copy(update={"rotor_inertia": rest})
    return robot.with_joint(table.model_copy(update={"actuator": actuator}))
