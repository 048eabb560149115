"""Feedforward torques of a wanted motion from a controller's model: the links' dynamics, and friction."""

from __future__ import annotations

from typing import Literal

import numpy as np

from mjfriction.body.inverse import inverse_dynamics
from mjfriction.control.course import Course
from mjfriction.laws.ambient import ambient
from mjfriction.laws.law import Floats
from mjfriction.robot.friction import stated_levels
from mjfriction.robot.robot import Robot
from mjfriction.robot.simulation import joint_laws

Feedforward = Literal["dynamics", "gravity", "none"]
FrictionFed = Literal["law", "coulomb_viscous", "none"]
TURNING = 0.02  # rad/s or m/s, width of the tanh that smooths the reversal in the feedforward of stated levels


def feedforward_rigid(model: Robot, what: Feedforward, course: Course) -> Floats:
    """Return the torques of links and rotors along a motion, all of them or gravity's alone, (n, joints)."""
    q, v, a = course.position, course.velocity, course.acceleration
    if what == "none":
        return np.zeros_like(q)
    moving = what == "dynamics"
    return inverse_dynamics(model.body(), q, v if moving else 0.0 * v, a if moving else 0.0 * a)


def feedforward_friction(model: Robot, what: FrictionFed, course: Course, step: float) -> Floats:
    """Return the friction torques along a motion whose rows are ``step`` seconds apart, (n, joints).

    They come from the friction laws, started at rest without deflection, or from the stated levels, smoothed around
    rest.
    """
    out = np.zeros_like(course.velocity)
    if what == "none":
        return out
    body = model.body()
    stated = model.with_stated_friction(body)
    if what == "coulomb_viscous":
        for i, joint in enumerate(stated.table.joint):
            coulomb, viscous = stated_levels(joint)
            velocity = course.velocity[:, i]
            out[:, i] = coulomb * np.tanh(velocity / TURNING) + viscous * velocity
        return out
    rotor = body.armature * course.acceleration
    load = feedforward_rigid(model, "dynamics", course) - rotor
    for i, joint in enumerate(stated.table.joint):
        around = ambient(load.shape[0], load=load[:, i], position=course.position[:, i], rotor=rotor[:, i])
        for law in joint_laws(joint):
            out[:, i] += law.follow(course.velocity[:, i], around, step)[0]
    return out
