"""The arms' passes, near-sinusoidal motion and pick and place, and the currents that each law tells."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from mjfriction.laws.law import Floats
from mjfriction.plant.trajectory import Trajectory
from mjfriction.record.log import Log
from mjfriction.reproduce.manipulator.arm import (
    AS_GOOD,
    STIFFNESSES,
    JointFit,
    classes,
    currents_measured,
    currents_told,
    dynamic_values,
    identify_arm,
    record,
    slow_sine,
    stated_arm,
    with_laws,
    work,
)
from mjfriction.reproduce.manipulator.load import LoadExtension, load_extension
from mjfriction.robot.robot import Robot

DAMPING_TIME = 1.9e-3  # s, σ₁/σ₀ of the document's first joint
LAWS = ("Coulomb-viscous", "static law", "dynamic law")
STEPS = 4  # of an arm's experiments


@dataclass(frozen=True)
class Told:
    """Currents of one motion: ``time``, ``measured`` (n, joints), what the ``links`` take of them, and what each law
    tells, A; ``speed`` is the wanted one of the motors, rad/s, (n, joints) all.
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
    """One arm's experiments: fits by joint, the bristle stiffnesses that explain the slow motion as well as any, what
    a payload adds, and the currents of both motions.
    """

    name: str
    classes: list[str]
    fits: list[JointFit]
    stiffness: list[tuple[float, float]]
    loads: list[LoadExtension]
    slow: Told
    work: Told


def run_arm(name: str, begin: Callable[[str], None], seed: int) -> Arm:
    """Run an arm's experiments; ``begin`` hears each of :data:`STEPS` as it begins."""
    begin(f"{name}: passes forward and backward")
    robot = stated_arm(name)
    fits = identify_arm(name, seed)
    begin(f"{name}: near-sinusoidal motion")
    trajectory = slow_sine(robot)
    log = record(name, trajectory, seed + 10)
    stiffness = _stiffnesses(robot, fits, trajectory, log)
    begin(f"{name}: pick and place")
    other = work(robot)
    best = np.array([pair[1] for pair in stiffness])
    models = {
        LAWS[0]: with_laws(robot, "coulomb_viscous", [fit.coulomb_viscous.values for fit in fits]),
        LAWS[1]: with_laws(robot, "arctan", [fit.static.values for fit in fits]),
        LAWS[2]: with_laws(robot, "lugre_arctan", dynamic_values(fits, best, DAMPING_TIME * best)),
    }
    slow = _told(models, trajectory, log)
    worked = _told(models, other, record(name, other, seed + 11))
    begin(f"{name}: passes with its payload")
    return Arm(name, classes(robot), fits, stiffness, load_extension(name, fits, seed + 20), slow, worked)


def _told(models: dict[str, Robot], trajectory: Trajectory, log: Log) -> Told:
    robot = next(iter(models.values()))
    ratios = np.array([joint.actuator.gear_ratio for joint in robot.table.joint])
    speed = trajectory.at(log.time)[1] * ratios
    links = currents_told(robot, trajectory, log, friction=False)
    by = {law: currents_told(model, trajectory, log) for law, model in models.items()}
    return Told(log.time, speed, currents_measured(log, robot), links, by)


def _stiffnesses(robot: Robot, fits: list[JointFit], trajectory: Trajectory, log: Log) -> list[tuple[float, float]]:
    # With the statics held, each joint's error for every stiffness: the least one that explains the slow motion as well
    # as any, and the best.
    measured = currents_measured(log, robot)
    errors = []
    for stiffness in STIFFNESSES.tolist():
        own = np.full(len(fits), stiffness)
        model = with_laws(robot, "lugre_arctan", dynamic_values(fits, own, DAMPING_TIME * own))
        told = currents_told(model, trajectory, log)
        errors.append(np.sqrt(np.mean(np.square(measured - told), axis=0)))
    out = []
    for column in np.array(errors).T:
        good = STIFFNESSES[column <= AS_GOOD * np.min(column)]
        out.append((float(good[0]), float(STIFFNESSES[int(np.argmin(column))])))
    return out
