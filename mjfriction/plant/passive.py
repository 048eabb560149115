"""Torques against the drives that do not depend on their own direction: cogging, ripple, springs, couplings."""

from __future__ import annotations

import numpy as np
from numpy.polynomial import polynomial

from mjfriction.laws.law import Floats
from mjfriction.robot.robot import Robot
from mjfriction.robot.rubbing import waves_along
from mjfriction.robot.schema import Spring
from mjfriction.robot.spring import coefficients

TURNING = 1e-3  # rad/s or m/s; velocity scale over which friction caused by another joint's motion reverses


def has_passive(robot: Robot) -> bool:
    """Return whether anything in a robot acts against its drives besides links and friction."""
    return any(
        joint.cogging or joint.actuator.ripple or joint.spring != Spring() or joint.coupling
        for joint in robot.table.joint
    )


class Passive:
    """The passive torques against a robot's drives, as a function.

    Its arguments are position, velocity, acceleration and drive torque, (joints,) each.
    """

    def __init__(self, robot: Robot) -> None:
        table = robot.table.joint
        self.cogging = [(i, joint.cogging) for i, joint in enumerate(table) if joint.cogging]
        self.ripple = [(i, joint.actuator.ripple) for i, joint in enumerate(table) if joint.actuator.ripple]
        self.springs = np.column_stack([coefficients(joint.spring) for joint in table])
        shape = (len(table), len(table))
        self.coulomb, self.viscous, self.inertia, self.effort = (np.zeros(shape) for _ in range(4))
        for i, joint in enumerate(table):
            for coupling in joint.coupling:
                k = robot.joints.index(coupling.joint)
                self.coulomb[i, k] += coupling.coulomb
                self.viscous[i, k] += coupling.viscous
                self.inertia[i, k] += coupling.inertia
                self.effort[i, k] += coupling.effort

    def __call__(self, position: Floats, velocity: Floats, acceleration: Floats, torque: Floats) -> Floats:
        """Return the passive torque against the drives at the joints, (joints,)."""
        out = polynomial.polyval(position, self.springs, tensor=False)
        for i, waves in self.cogging:
            out[i] += waves_along(waves, position[i : i + 1])[0]
        for i, waves in self.ripple:
            out[i] -= torque[i] * waves_along(waves, position[i : i + 1])[0]
        direction = np.tanh(velocity / TURNING)
        moved = self.coulomb @ direction + self.viscous @ velocity + self.inertia @ acceleration
        return np.asarray(out + moved + self.effort @ torque)
