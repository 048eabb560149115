"""A robot without friction."""

from __future__ import annotations

from mjfriction.robot.friction_tables import FrictionTerm
from mjfriction.robot.robot import Robot


def frictionless(robot: Robot) -> Robot:
    """Return the robot with nothing that rubs at any joint."""
    none = FrictionTerm(law="coulomb_viscous", parameters={"coulomb": 0.0, "viscous": 0.0})
    for joint in robot.table.joint:
        robot = robot.with_joint(joint.model_copy(update={"friction": (none,)}))
    return robot
