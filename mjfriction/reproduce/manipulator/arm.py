"""The manipulator document's arms, richer than every law under test: experiments and identification."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pyarrow as pa

from mjfriction.body.gravity_pose import gravity_pose
from mjfriction.control.course import Course
from mjfriction.control.feedforward import feedforward_friction, feedforward_rigid
from mjfriction.control.servo import Control
from mjfriction.errors import LogError
from mjfriction.identify.friction_map import FrictionMap, friction_maps
from mjfriction.identify.map_fit import MapFit, arctan_procedure, fit_map, on_side
from mjfriction.identify.pendulum import ByPendulum, by_pendulum
from mjfriction.identify.phases import constant_speed_phases
from mjfriction.identify.protocol import plan_passes, room
from mjfriction.laws.ambient import ambient
from mjfriction.laws.catalog import find_law
from mjfriction.laws.law import Floats
from mjfriction.plant.machine import simulate
from mjfriction.plant.motions import pick_and_place
from mjfriction.plant.sensors import Recorder
from mjfriction.plant.trajectory import Trajectory
from mjfriction.record.log import CURRENT, Log
from mjfriction.record.motion import Motion, estimate_motion
from mjfriction.record.readers.table import log_from_table
from mjfriction.robot.bandwidth import choose_cutoff
from mjfriction.robot.body_tables import Payload
from mjfriction.robot.effort import effort_per_reported
from mjfriction.robot.files import read_robot
from mjfriction.robot.friction_tables import FrictionTerm, LevelTable
from mjfriction.robot.robot import Robot
from mjfriction.robot.table import Wave

ARMS = ("comau_ns12", "comau_nj60")
SLOWEST, FASTEST = 0.8, 400.0  # rad/s; range of motor speeds, the document's
FITTED, CHECKED = 12, 7  # number of speeds in the passes for identification and in the held-out passes
PER_LOAD = 0.02  # 1/(N·m) at the motor; relative growth of a joint's level with the torque that it transmits
RIPPLE = 0.015  # cogging as a share of the static level, twice per motor turn, independent of direction
LINKS_OFF = 0.03  # share by which mass and inertia of every link are off the stated ones
RATE = 500.0  # Hz of the logs
BANDWIDTH = 20.0  # Hz of the arms' own control
SLOW_AMPLITUDE, SLOW_FREQUENCY, SLOW_PERIODS = 0.25, 0.1, 2.0  # rad, Hz, 1: near-sinusoidal motion


@dataclass(frozen=True)
class JointFit:
    """The results of the passes for one joint, on the motor's side.

    ``points`` is its friction map.  The laws are Coulomb-viscous friction, law (14) by least squares (``static``) and
    law (14) by the document's ``procedure`` (None where friction does not fall).  ``checked`` is the RMS error of the
    first two on held-out passes, N·m.

    ``off`` is the RMS deviation of friction from the machine's own over the speeds, N·m: from passes one way, with
    gravity removed by the stated model's pendulum and by a fitted one, and from passes both ways.
    """

    points: FrictionMap
    ratio: float
    coulomb_viscous: MapFit
    static: MapFit
    procedure: MapFit | None
    checked: tuple[float, float]
    off: tuple[float, float, float]


def stated_arm(name: str) -> Robot:
    """Return an arm as its user knows it."""
    return read_robot(name)


def true_arm(name: str) -> Robot:
    """Return the machine: law (22) to (29) with levels that grow with the load, ripple, links that are a little off."""
    robot = read_robot(name)
    off = {joint: 1.0 + LINKS_OFF * (-1.0) ** k for k, joint in enumerate(robot.joints)}
    robot = Robot(robot.table.model_copy(update={"link_scale": off}), robot.folder)
    for joint in robot.table.joint:
        (law,) = joint.friction or ()
        ratio = joint.actuator.gear_ratio
        wave = Wave(wavenumber=2.0 * ratio, cosine=RIPPLE * law.value("static") * ratio)
        loaded = law.model_copy(update={"level": LevelTable(per_load=PER_LOAD)})
        robot = robot.with_joint(joint.model_copy(update={"friction": (loaded,), "cogging": (wave,)}))
    return robot


def classes(robot: Robot) -> list[str]:
    """Return how gravity loads each joint, in words."""
    body = robot.body()
    return [gravity_pose(body, joint).kind.value for joint in range(len(robot.joints))]


def identify_arm(name: str, seed: int = 0) -> list[JointFit]:
    """Run passes of every joint, identify its statics, and check them on held-out passes at other speeds."""
    robot, out = stated_arm(name), []
    passes, others = (record_passes(name, count, robot.joints, seed + k) for k, count in enumerate((FITTED, CHECKED)))
    fitted, checked = maps_of(passes, robot), maps_of(others, robot)
    motion, torque = _efforts(passes, robot)
    phases, body = constant_speed_phases(motion), robot.body()
    for i, joint in enumerate(robot.table.joint):
        ratio = joint.actuator.gear_ratio
        if i not in fitted or i not in checked:
            raise LogError(f"joint '{joint.name}' of '{name}' has no phases of constant speed in its passes")
        plain, static = (fit_map(fitted[i], find_law(law), "motor", ratio) for law in ("coulomb_viscous", "arctan"))
        try:
            procedure = arctan_procedure(fitted[i], "motor", ratio)
        except LogError:
            procedure = None
        left = (_left(plain, checked[i], ratio), _left(static, checked[i], ratio))
        pendulum = by_pendulum(motion, torque[:, i], robot, body, phases, i)
        assert pendulum is not None  # a hinge that has a map has enough passes
        off = _off_truth(name, fitted[i], pendulum)
        out.append(JointFit(fitted[i], ratio, plain, static, procedure, left, off))
    return out


def record_passes(name: str, count: int, joints: Sequence[str], seed: int, payload: float = 0.0) -> Log:
    """Return the log of passes of joints one after another at ``count`` motor speeds, with a payload (kg)."""
    robot = stated_arm(name)
    speeds = {
        joint.name: np.geomspace(SLOWEST, FASTEST, count) / joint.actuator.gear_ratio for joint in robot.table.joint
    }
    return record(name, plan_passes(robot, joints, speeds=speeds, seed=seed).trajectory, seed, payload)


def maps_of(log: Log, robot: Robot) -> dict[int, FrictionMap]:
    """Return the friction maps of a log of passes, by joint."""
    motion, torque = _efforts(log, robot)
    return {points.joint: points for points in friction_maps(motion, torque, constant_speed_phases(motion))}


def _efforts(log: Log, robot: Robot) -> tuple[Motion, Floats]:
    motion = estimate_motion(log, robot.joints, choose_cutoff(log, robot, robot.body()))
    return motion, motion.torque * _per_ampere(robot)


def _per_ampere(robot: Robot) -> Floats:
    return np.array([effort_per_reported(joint, CURRENT, robot.name) for joint in robot.table.joint])


def with_payload(robot: Robot, mass: float) -> Robot:
    """Return an arm that holds a mass (kg) 10 cm in front of its flange."""
    if mass == 0.0:
        return robot
    held = Payload(mass=mass, com=(0.1, 0.0, 0.0), parent="flange")
    return Robot(robot.table.model_copy(update={"payload": held}), robot.folder)


def record(name: str, trajectory: Trajectory, seed: int, payload: float = 0.0) -> Log:
    """Return the log of currents that an arm's own controller, which knows its payload, records along a trajectory."""
    columns = simulate(
        with_payload(true_arm(name), payload),
        trajectory,
        recorder=Recorder(RATE, quantity=CURRENT),
        control=Control(bandwidth=BANDWIDTH, friction="law"),
        controller_robot=with_payload(stated_arm(name), payload),
        seed=seed,
    )
    return log_from_table(pa.table(columns), f"{name}, simulated")


def _left(fit: MapFit, points: FrictionMap, ratio: float) -> float:
    speed, friction, _ = on_side(points, "motor", ratio)
    told = fit.law.along(speed, ambient(speed.size), fit.law.pack(fit.values))
    return float(np.sqrt(np.mean(np.square(friction - told))))


def _off_truth(name: str, points: FrictionMap, pendulum: ByPendulum) -> tuple[float, float, float]:
    joint = true_arm(name).table.joint[points.joint]
    ratio = joint.actuator.gear_ratio
    (own,) = [term.friction(ratio) for term in joint.friction or ()]

    def off(*passes: tuple[Floats, Floats]) -> float:
        missed = []
        for speed, friction in passes:
            load = np.interp(speed, points.speed, points.load)
            missed.append((friction - own.steady(speed, ambient(speed.size, load=load))) / ratio)
        return float(np.sqrt(np.mean(np.square(np.concatenate(missed)))))

    model, fitted = (
        off((pendulum.forward, pendulum.forward_friction[:, k]), (pendulum.backward, pendulum.backward_friction[:, k]))
        for k in range(2)
    )
    return model, fitted, off((points.speed, points.friction))


def with_laws(robot: Robot, law: str, values: list[dict[str, float]]) -> Robot:
    """Return an arm with one law, on the motor's side, at every joint."""
    for joint, own in zip(robot.table.joint, values, strict=True):
        term = FrictionTerm(law=law, side="motor", parameters=dict(own))
        robot = robot.with_joint(joint.model_copy(update={"friction": (term,)}))
    return robot


def slow_sine(robot: Robot) -> Trajectory:
    """Return the near-sinusoidal motion of all joints, each at its own phase."""
    middle, reach = room(robot.body())
    time = np.arange(0.0, SLOW_PERIODS / SLOW_FREQUENCY + 1e-9, 0.004)
    share = np.clip(np.minimum(time, time[-1] - time) / (0.5 / SLOW_FREQUENCY), 0.0, 1.0)
    swell = share**3 * (10.0 - 15.0 * share + 6.0 * share**2)
    phases = 2.0 * np.pi * (SLOW_FREQUENCY * time[:, None] + np.arange(middle.size) / middle.size)
    place = middle + np.minimum(SLOW_AMPLITUDE, reach) * swell[:, None] * np.sin(phases)
    return Trajectory(robot.joints, time, place)


def work(robot: Robot) -> Trajectory:
    """Return a pick-and-place motion between four poses."""
    body = robot.body()
    middle, reach = room(body)
    poses = middle + 0.6 * reach * np.random.default_rng(7).uniform(-1.0, 1.0, (4, middle.size))
    top = np.minimum(body.top_speed, 1.5)
    return pick_and_place(robot.joints, poses, top, 2.0 * top, rounds=1)


def currents_told(robot: Robot, trajectory: Trajectory, log: Log, *, friction: bool = True) -> Floats:
    """Return the motors' currents, (n, joints) at the log's instants, that a model predicts along the wanted motion.

    Without ``friction``, only the part that its links need.
    """
    step = float(np.median(np.diff(log.time)))
    course = Course(*trajectory.at(log.time))
    torque = feedforward_rigid(robot, "dynamics", course)
    if friction:
        torque = torque + feedforward_friction(robot, "law", course, step)
    return np.asarray(torque / _per_ampere(robot))


def currents_measured(log: Log, robot: Robot) -> Floats:
    """Return the currents of a log, (n, joints), A."""
    return np.column_stack([log.columns[f"{CURRENT}.{name}"] for name in robot.joints])
