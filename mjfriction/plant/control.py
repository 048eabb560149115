"""Joint control of a machine: feedforward of its model, PD, and the currents that its drives make of it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from mjfriction.body.inverse import inverse_dynamics, mass_matrix_at
from mjfriction.laws.law import Floats
from mjfriction.robot.friction import stated_levels
from mjfriction.robot.robot import Robot

FEEDFORWARD_SPEED = 0.02  # rad/s or m/s over which the feedforward of dry friction turns over
STEADY = 0.5  # of a joint's speed, that its damping may take within a step
POSES = 50  # of a course, of which the heaviest sets a joint's gains


@dataclass(frozen=True)
class Control:
    """Joint PD and feedforward: ``bandwidth`` (Hz) and ``damping`` ratio of every joint on its own inertia, less where
    the joint would ring at the step of the simulation.

    ``feedforward`` is what is fed forward of the controller's robot: its ``"dynamics"``, its ``"gravity"`` alone, or
    ``"none"``; ``friction`` adds its stated Coulomb and viscous friction.
    """

    bandwidth: float = 4.0
    damping: float = 0.8
    feedforward: Literal["dynamics", "gravity", "none"] = "dynamics"
    friction: bool = True


@dataclass(frozen=True)
class Course:
    """What the joints are to do at every step: position, velocity, acceleration, each (n, joints)."""

    position: Floats
    velocity: Floats
    acceleration: Floats


class ServoDrives:
    """Drives of all joints under control: a function of the step, position and velocity, (joints,) each.

    What the controller asks for is limited by the drives' currents and lags behind by their current loops.
    """

    def __init__(self, robot: Robot, model: Robot, control: Control, course: Course, step: float) -> None:
        self.course = course
        self.feedforward = _feedforward(model, control, course)
        self.stiffness, self.damping = _gains(robot, control, course.position, step)
        self.limit = np.array([_effort_limit(robot, i) for i in range(len(robot.joints))])
        bandwidths = [joint.actuator.current_bandwidth for joint in robot.table.joint]
        self.share = np.array([-np.expm1(-2.0 * np.pi * hertz * step) if hertz else 1.0 for hertz in bandwidths])
        self.made = np.clip(self.feedforward[0], -self.limit, self.limit)

    def __call__(self, k: int, position: Floats, velocity: Floats) -> Floats:
        """Return what the drives push with through step ``k``, (joints,), N·m or N."""
        asked = self.feedforward[k] + self.stiffness * (self.course.position[k] - position)
        asked += self.damping * (self.course.velocity[k] - velocity)
        asked = np.minimum(np.maximum(asked, -self.limit), self.limit)
        self.made = self.made + self.share * (asked - self.made)
        return np.asarray(self.made)


def _effort_limit(robot: Robot, joint: int) -> float:
    # Infinite where the robot file states no limit.
    drive = robot.table.joint[joint].actuator
    if drive.current_limit is None or drive.torque_constant is None:
        return float("inf")
    return drive.current_limit * drive.torque_constant * abs(drive.gear_ratio)


def _feedforward(robot: Robot, control: Control, course: Course) -> Floats:
    body = robot.body()
    robot = robot.with_stated_friction(body)
    q, v, a = course.position, course.velocity, course.acceleration
    if control.feedforward == "none":
        torque = np.zeros_like(q)
    elif control.feedforward == "gravity":
        torque = inverse_dynamics(body, q, 0.0 * v, 0.0 * a)
    else:
        torque = inverse_dynamics(body, q, v, a)
    if control.friction:
        for i, joint in enumerate(robot.table.joint):
            coulomb, viscous = stated_levels(joint)
            torque[:, i] += coulomb * np.tanh(v[:, i] / FEEDFORWARD_SPEED) + viscous * v[:, i]
    return torque


def _gains(robot: Robot, control: Control, q: Floats, step: float) -> tuple[Floats, Floats]:
    body = robot.body()
    masses = [mass_matrix_at(body, pose) for pose in q[:: max(1, q.shape[0] // POSES)]]
    inertia = np.max([np.diag(mass) for mass in masses], axis=0)
    # What a joint weighs while the others give way: much less, on an arm with light rotors.
    least = np.min([1.0 / np.diag(np.linalg.inv(mass)) for mass in masses], axis=0)
    damping = 2.0 * control.damping * inertia * 2.0 * np.pi * control.bandwidth
    share = np.minimum(1.0, STEADY * least / np.maximum(step * damping, 1e-300))
    angular = 2.0 * np.pi * control.bandwidth * share
    return inertia * angular**2, share * damping
