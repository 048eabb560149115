"""What the links of a robot and what it holds need along a motion."""

from __future__ import annotations

import numpy as np

from mjfriction.body.inverse import inverse_dynamics
from mjfriction.body.model import Body, Load
from mjfriction.errors import LogError, RobotError
from mjfriction.laws.law import Floats
from mjfriction.record.log import HELD_MASS
from mjfriction.record.motion import Motion
from mjfriction.robot.robot import Robot


def held_mass(robot: Robot, motion: Motion) -> Floats | None:
    """Return the mass (n,), kg, that the motion's log says was held where the robot holds one; None where either is
    silent.

    Raises :class:`LogError` for a mass below zero.
    """
    mass = motion.columns.get(HELD_MASS)
    if mass is None or robot.table.held is None:
        return None
    if np.any(mass < 0.0):
        raise LogError(f"column '{HELD_MASS}' holds {np.min(mass):g}; a mass is 0 kg or more")
    return mass


def held_torque(robot: Robot, body: Body, motion: Motion) -> Floats:
    """Return the torques of what the motion's log says was held, (n, joints), N·m or N: none where it says nothing.

    A point mass m at a fixed place of a link adds m times what one kilogram there adds.
    """
    mass, held = held_mass(robot, motion), robot.table.held
    if mass is None or held is None:
        return np.zeros_like(motion.position)
    try:
        laden = body.holding(Load(1.0, held.com, held.parent))
    except RobotError as error:
        raise RobotError(f"robot '{robot.name}': held: {error}") from None
    course = motion.position, motion.velocity, motion.acceleration
    return np.asarray(mass[:, None] * (inverse_dynamics(laden, *course) - inverse_dynamics(body, *course)))


def links_torque(robot: Robot, body: Body, motion: Motion) -> Floats:
    """Return the torques of links, payload, rotors and of what the log says was held besides, (n, joints), N·m or N."""
    torque = inverse_dynamics(body, motion.position, motion.velocity, motion.acceleration)
    return torque if held_mass(robot, motion) is None else torque + held_torque(robot, body, motion)
