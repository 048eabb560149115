"""The torques that a robot's links and the masses it holds need along a motion."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mjfriction.body.inverse import inverse_dynamics
from mjfriction.body.model import Body, Load
from mjfriction.errors import RobotError
from mjfriction.laws.law import Floats
from mjfriction.record.log import HELD_MASS
from mjfriction.record.motion import Motion
from mjfriction.record.span import within
from mjfriction.robot.body_tables import Place
from mjfriction.robot.robot import Robot


def held_mass(robot: Robot, motion: Motion) -> Floats | None:
    """Return the held mass (n,), kg, from the log's column.

    None if the log has no such column or the robot file does not state where the mass is held.
    """
    return None if robot.table.held is None else motion.columns.get(HELD_MASS)


def held_torque(robot: Robot, body: Body, motion: Motion) -> Floats:
    """Return the torques of the masses held in addition to the payload, (n, joints), N·m or N.

    These are the mass that the motion's log reports, and the masses that the robot takes up for a while.
    """
    out, mass, held = np.zeros_like(motion.position), held_mass(robot, motion), robot.table.held
    if mass is not None and held is not None:
        out += mass[:, None] * _of_one_kilogram(robot, body, held, motion, slice(None), "held")
    for load in robot.table.taken_up:
        own = is_held(load.begin, load.end, motion.time)
        out[own] += load.mass * _of_one_kilogram(robot, body, load, motion, own, "taken_up")
    return out


def is_held(begin: float, end: float | None, time: Floats) -> NDArray[np.bool_]:
    """Return at which of the times (n,), s, a mass is held that is taken up at ``begin`` and put down at ``end``."""
    return within((begin, np.inf if end is None else end), time)


def _of_one_kilogram(
    robot: Robot, body: Body, place: Place, motion: Motion, own: slice | NDArray[np.bool_], key: str
) -> Floats:
    # The torque of a point mass at a fixed place of a link is proportional to the mass: compute it per kilogram.
    try:
        alone = body.weightless().holding(Load(1.0, place.com, place.parent))
    except RobotError as error:
        raise RobotError(f"robot '{robot.name}': {key}: {error}") from None
    return inverse_dynamics(alone, motion.position[own], motion.velocity[own], motion.acceleration[own])


def links_torque(robot: Robot, body: Body, motion: Motion) -> Floats:
    """Return the torques of links, payload, rotors and additional held masses, (n, joints), N·m or N."""
    torque = inverse_dynamics(body, motion.position, motion.velocity, motion.acceleration)
    besides = robot.table.taken_up or held_mass(robot, motion) is not None
    return torque + held_torque(robot, body, motion) if besides else torque
