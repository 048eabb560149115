"""The arms' passes, near-sinusoidal motion and pick and place, and the currents that each law predicts."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from mjfriction.identify.bristle_fit import BristleFit, fit_bristle
from mjfriction.laws.law import Floats
from mjfriction.laws.lugre_arctan import LUGRE_ARCTAN
from mjfriction.plant.trajectory import Trajectory
from mjfriction.record.log import Log
from mjfriction.reproduce.manipulator.arm import (
    JointFit,
    classes,
    currents_measured,
    currents_told,
    identify_arm,
    record,
    slow_sine,
    stated_arm,
    with_laws,
    work,
)
from mjfriction.reproduce.manipulator.load import LoadExtension, load_extension
from mjfriction.robot.robot import Robot

LAWS = ("Coulomb-viscous", "static law", "dynamic law")
STEPS = 4  # progress steps of an arm's experiments


@dataclass(frozen=True)
class Told:
    """Currents along one motion at ``time`` (n,), A, (n, joints) each.

    They are the ``measured`` ones, the part that the ``links`` need, and the predictions ``by`` each law.  ``speed``
    (n, joints) is the wanted speed of the motors, rad/s.
    """

    time: Floats
    speed: Floats
    measured: Floats
    links: Floats
    by: dict[str, Floats]

    def rms(self, law: str) -> Floats:
        """RMS error, A, (joints,)."""
        return np.asarray(np.sqrt(np.mean(np.square(self.measured - self.by[law]), axis=0)))


@dataclass(frozen=True)
class Arm:
    """One arm's experiments.

    Fits by joint, bristles identified from the slow motion, what a payload adds to friction, and the currents of both
    motions.
    """

    name: str
    classes: list[str]
    fits: list[JointFit]
    bristles: list[BristleFit]
    loads: list[LoadExtension]
    slow: Told
    work: Told


def run_arm(name: str, begin: Callable[[str], None], seed: int) -> Arm:
    """Run an arm's experiments; ``begin`` is called as each of the :data:`STEPS` steps begins."""
    begin(f"{name}: passes forward and backward")
    robot = stated_arm(name)
    fits = identify_arm(name, seed)
    begin(f"{name}: near-sinusoidal motion")
    trajectory = slow_sine(robot)
    log = record(name, trajectory, seed + 10)
    bristles = _bristles(robot, fits, trajectory, log)
    begin(f"{name}: pick and place")
    other = work(robot)
    models = {
        LAWS[0]: with_laws(robot, "coulomb_viscous", [fit.coulomb_viscous.values for fit in fits]),
        LAWS[1]: with_laws(robot, "arctan", [fit.static.values for fit in fits]),
        LAWS[2]: with_laws(robot, "lugre_arctan", [fit.together for fit in bristles]),
    }
    slow = _told(models, trajectory, log)
    worked = _told(models, other, record(name, other, seed + 11))
    begin(f"{name}: passes with its payload")
    return Arm(name, classes(robot), fits, bristles, load_extension(name, seed + 20), slow, worked)


def _told(models: dict[str, Robot], trajectory: Trajectory, log: Log) -> Told:
    robot = next(iter(models.values()))
    ratios = np.array([joint.actuator.gear_ratio for joint in robot.table.joint])
    speed = trajectory.at(log.time)[1] * ratios
    links = currents_told(robot, trajectory, log, friction=False)
    by = {law: currents_told(model, trajectory, log) for law, model in models.items()}
    return Told(log.time, speed, currents_measured(log, robot), links, by)


def _bristles(robot: Robot, fits: list[JointFit], trajectory: Trajectory, log: Log) -> list[BristleFit]:
    # Fit along the wanted motion, as the document's simulator does, so that the machine's own jitter is not fitted.
    left = currents_measured(log, robot) - currents_told(robot, trajectory, log, friction=False)
    step, speed = float(np.median(np.diff(log.time))), trajectory.at(log.time)[1]
    out = []
    for i, (joint, fit) in enumerate(zip(robot.table.joint, fits, strict=True)):
        constant, ratio = joint.actuator.torque_constant, joint.actuator.gear_ratio
        assert constant is not None
        course = ratio * speed[:, i], constant * left[:, i]
        out.append(fit_bristle(LUGRE_ARCTAN, fit.static, fit.points, "motor", ratio, *course, step))
    return out
