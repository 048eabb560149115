"""Joint control of a machine: PD control, model-based feedforward, friction compensation, and drives that lag."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import get_args

import numpy as np

from mjfriction.body.inverse import mass_matrix_at
from mjfriction.control.course import Course
from mjfriction.control.feedforward import Feedforward, FrictionFed, feedforward_friction, feedforward_rigid
from mjfriction.control.observer import Observer, ObserverFor
from mjfriction.control.sensing import Sensing
from mjfriction.control.valve import ValveControl
from mjfriction.errors import ControlError, RobotError, suggestion
from mjfriction.laws.law import Floats
from mjfriction.robot.robot import Robot
from mjfriction.robot.rubbing import waves_along

STEADY = 0.5  # largest fraction of a joint's speed that its damping may remove within a step
POSES = 50  # poses of a course (about) at which inertia is computed; the largest sets a joint's gains


@dataclass(frozen=True)
class Control:
    """Joint PD control with feedforward.

    ``bandwidth`` (Hz) and ``damping`` ratio apply to every joint on its own inertia.  They are reduced where the joint
    would ring at the step of the simulation.

    ``feedforward`` from the controller's robot model is its ``"dynamics"``, its ``"gravity"`` alone, or ``"none"``.
    ``friction`` fed forward along the wanted motion is the model's ``"law"``, its stated ``"coulomb_viscous"`` levels,
    or ``"none"``.  ``observer`` makes an observer of the remaining friction at every joint, whose estimate F̂ is fed
    back: with u = PD + feedforward, the drive gives u + F̂, and F̂ is estimated from the force that moves the mass less
    the friction fed forward.  With ``cancels_cogging`` the stated cogging at the position read is added.

    With ``sensed`` the controller reads positions as the robot's sensors report them, with noise from ``seed``, instead
    of true positions.  ``valve`` controls hydraulic joints (:mod:`mjfriction.control.valve`).

    Raises :class:`~mjfriction.errors.ControlError` for another word, or a bandwidth or damping that is not positive.
    """

    bandwidth: float = 4.0
    damping: float = 0.8
    feedforward: Feedforward = "dynamics"
    friction: FrictionFed = "coulomb_viscous"
    observer: ObserverFor | None = None
    cancels_cogging: bool = False
    sensed: bool = False
    seed: int = 0
    valve: ValveControl | None = None

    def __post_init__(self) -> None:
        for name, given, allowed in (
            ("feedforward", self.feedforward, get_args(Feedforward)),
            ("friction", self.friction, get_args(FrictionFed)),
        ):
            if given not in allowed:
                raise ControlError(
                    f"{name} = {given!r} is none of {', '.join(allowed)}{suggestion(str(given), allowed)}"
                )
        for name, value in (("bandwidth", self.bandwidth), ("damping", self.damping)):
            if not 0.0 < value < math.inf:
                raise ControlError(f"{name} = {value:g} of a controller: allowed is any finite number above 0")


class ServoDrives:
    """Controlled drives of all joints: a function of the step, and of position and velocity, (joints,) each.

    The controller's demand is limited by the drives' currents and lags by their current loops.  ``estimates``
    (n, joints) is the friction that the controller assumed at every step, fed forward and observed.
    """

    def __init__(self, robot: Robot, model: Robot, control: Control, course: Course, step: float) -> None:
        self.course, self.step = course, step
        self.stiffness, self.damping = _gains(robot, control, course.position, step)
        self.mass = _heaviest(_masses(model, course.position))
        self.rigid = feedforward_rigid(model, control.feedforward, course)
        self.friction = feedforward_friction(model, control.friction, course, step)
        # Hydraulic joints have no electric drive; their valves have controllers of their own.
        driven = [i for i, joint in enumerate(robot.table.joint) if joint.hydraulics is None]
        self.friction[:, np.delete(np.arange(len(robot.joints)), driven)] = 0.0
        self.limit = np.array([_effort_limit(robot, i) for i in range(len(robot.joints))])
        bandwidths = [joint.actuator.current_bandwidth for joint in robot.table.joint]
        self.share = np.array([-np.expm1(-2.0 * np.pi * hertz * step) if hertz else 1.0 for hertz in bandwidths])
        self.made = np.clip(self.rigid[0] + self.friction[0], -self.limit, self.limit)
        self.sensing = Sensing(robot, control.seed, step) if control.sensed else None
        self.cogging = [
            (i, joint.cogging) for i, joint in enumerate(model.table.joint) if control.cancels_cogging and joint.cogging
        ]
        make = control.observer
        self.observers = {i: _observer(make, float(self.mass[i]), step) for i in driven} if make else {}
        self.known = {
            i: observer.start(float(course.position[0, i]), float(course.velocity[0, i]))
            for i, observer in self.observers.items()
        }
        self.estimate = np.zeros(self.mass.size)
        self.estimates = np.zeros_like(course.position)
        # The forces that move a joint other than its drive and its friction, according to the model.
        known = feedforward_rigid(model, "dynamics" if make else "none", course)
        self.beside = self.mass * course.acceleration - known

    def __call__(self, k: int, position: Floats, velocity: Floats) -> Floats:
        """Return the torques of the drives over step ``k``, (joints,), N·m or N."""
        if self.sensing is not None:
            position, velocity = self.sensing(position, velocity)
        self.estimates[k] = self.friction[k] + self.estimate
        known = self.friction[k].copy()
        for i, waves in self.cogging:
            known[i] += waves_along(waves, position[i : i + 1])[0]
        asked = self.rigid[k] + known + self.stiffness * (self.course.position[k] - position)
        asked += self.damping * (self.course.velocity[k] - velocity) + self.estimate
        asked = np.minimum(np.maximum(asked, -self.limit), self.limit)
        self.made = self.made + self.share * (asked - self.made)
        for i, observer in self.observers.items():
            force = float(self.made[i] + self.beside[k, i] - known[i])
            self.known[i], self.estimate[i], _ = observer.step(
                self.known[i], float(position[i]), float(velocity[i]), force, self.step
            )
        return np.asarray(self.made)


def _observer(make: ObserverFor, mass: float, step: float) -> Observer:
    observer = make(mass, step)
    observer.check_step(step)
    return observer


def _effort_limit(robot: Robot, joint: int) -> float:
    # Infinite where the robot file states no limit.
    drive = robot.table.joint[joint].actuator
    if drive.current_limit is None or drive.effort_per_ampere is None:
        return float("inf")
    return drive.current_limit * abs(drive.effort_per_ampere)


def _masses(robot: Robot, q: Floats) -> list[Floats]:
    body = robot.body()
    return [mass_matrix_at(body, pose) for pose in q[:: max(1, q.shape[0] // POSES)]]


def _heaviest(masses: list[Floats]) -> Floats:
    return np.asarray(np.max([np.diag(mass) for mass in masses], axis=0))


def _gains(robot: Robot, control: Control, q: Floats, step: float) -> tuple[Floats, Floats]:
    masses = _masses(robot, q)
    inertia = _heaviest(masses)
    for joint, own in zip(robot.joints, inertia, strict=True):
        if own <= 0.0:
            raise RobotError(
                f"{robot.model_path}: nothing that joint '{joint}' moves has a mass; state its links' <inertial> in "
                f"the model, or a rotor_inertia of '{joint}' in the robot file"
            )
    # A joint's effective inertia while the others move freely: much less than its own, on an arm with light rotors.
    least = np.min([1.0 / np.diag(np.linalg.inv(mass)) for mass in masses], axis=0)
    damping = 2.0 * control.damping * inertia * 2.0 * np.pi * control.bandwidth
    share = np.minimum(1.0, STEADY * least / np.maximum(step * damping, 1e-300))
    angular = 2.0 * np.pi * control.bandwidth * share
    return inertia * angular**2, share * damping
