"""Friction along a log, joint by joint: the remainder of the torque balance, or an observer's estimate."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from mjfriction.body.inverse import inertia_along
from mjfriction.control.bristle_observer import STIFFNESS, BristleObserver
from mjfriction.control.disturbance import DisturbanceObserver
from mjfriction.control.friedland import FriedlandMentzelopoulou, FriedlandPark, Tafazoli
from mjfriction.control.observer import Observer, estimate_along
from mjfriction.control.variable_structure import VariableStructure
from mjfriction.errors import ControlError, LogError, suggestion
from mjfriction.laws.law import Floats
from mjfriction.record.log import VELOCITY, Log, check_joints
from mjfriction.record.motion import Motion, back_to_log, smooth_derivatives
from mjfriction.robot.bandwidth import choose_cutoff
from mjfriction.robot.effort import as_given, effort_per_reported, predict_effort, without_offsets
from mjfriction.robot.measured_motion import measured_motion
from mjfriction.robot.robot import Robot
from mjfriction.robot.schema import Joint
from mjfriction.robot.simulation import joint_laws

USUAL_BANDWIDTH = 10.0  # Hz, default bandwidth of an observer
SLIDING_STEPS = 3.0  # time constant of the position error within the smooth switching, in steps
SURE = 3.0  # switching gain, in units of the velocity error that the whole force would cause if it were unexplained
SETTLED = 4.0  # time constants after which an observer has forgotten its initial state

Maker = Callable[[Joint, float, float, float, float], Observer]
"""(joint, mass, step, rate in rad/s, largest force) → an observer whose errors die away at about that rate."""


def _bristle(joint: Joint, mass: float, step: float, rate: float, force: float) -> Observer:
    del step, force
    laws = joint_laws(joint)
    place = laws[0].law.index(STIFFNESS) if len(laws) == 1 else None
    if place is None:
        raise ControlError(
            f"joint '{joint.name}': the bristle observer goes by the joint's one law with a bristle, such as 'lugre'; "
            "state it in the robot file, or take another observer"
        )
    # e_v' = −σ₀·e_z/m − l·e_v, e_z' = γ·e_v: choose l and γ so that both rates equal the requested one.
    stiffness = float(laws[0].values[place]) * laws[0].gear_ratio ** 2
    return BristleObserver(mass, laws[0], 2.0 * rate, mass * rate * rate / stiffness)


def _sliding(joint: Joint, mass: float, step: float, rate: float, force: float) -> Observer:
    del joint
    switching = SURE * force / (mass * rate)
    return VariableStructure.with_rate(mass, rate, switching, SLIDING_STEPS * switching * step)


OBSERVERS: dict[str, Maker | None] = {
    "balance": None,
    "disturbance": lambda _, mass, step, rate, __: DisturbanceObserver.with_bandwidth(mass, step, rate / (2.0 * np.pi)),
    "friedland_park": lambda _, mass, __, rate, ___: FriedlandPark(mass, rate),
    "friedland_mentzelopoulou": lambda _, mass, __, rate, ___: FriedlandMentzelopoulou(mass, rate, 2.0 * rate),
    "tafazoli": lambda _, mass, __, rate, ___: Tafazoli(mass, rate, 2.0 * rate),
    "variable_structure": _sliding,
    "bristle": _bristle,
}
"""The observers by name, each made from one bandwidth; ``balance`` is what the log leaves, without any."""


def observe_log(
    log: Log, robot: Robot, observer: str = "balance", bandwidth: float = USUAL_BANDWIDTH
) -> dict[str, Floats]:
    """Return ``time`` and, for every joint with an effort or a current, ``friction.<joint>`` and ``velocity.<joint>``.

    Units are N·m and rad/s at the joint (N, m/s).  The rest of the robot is taken as stated: links, gravity, rotors,
    cogging, springs, couplings, sensors.  ``balance`` takes accelerations from the log's non-causal filter and needs no
    observer.  The others show what an observer running in real time would have estimated, including its lag.  Rows are
    those of the log's file, NaN where a row was dropped and where an observer had not settled yet.

    Raises :class:`ControlError` for an unknown observer or one that cannot work on this log, and
    :class:`~mjfriction.errors.LogError` or :class:`~mjfriction.errors.RobotError` if log or robot cannot be used.
    """
    if observer not in OBSERVERS:
        raise ControlError(
            f"there is no observer '{observer}'{suggestion(observer, OBSERVERS)} There are {', '.join(OBSERVERS)}"
        )
    if not (np.isfinite(bandwidth) and bandwidth > 0.0):
        raise ControlError(f"bandwidth = {bandwidth:g} Hz; allowed is any finite number above 0")
    body = robot.body()
    robot = robot.with_stated_friction(body)
    check_joints(log, robot.name, robot.joints)
    motion = measured_motion(log, robot, body, choose_cutoff(log, robot, body))
    effort = predict_effort(robot, body, motion)
    mass = np.mean(inertia_along(body, motion.position), axis=0) + body.armature
    place = without_offsets(robot, motion).position
    columns = {"time": log.time if log.recorded is None else log.recorded}
    for i, joint in enumerate(robot.table.joint):
        if motion.quantity[i] is None:
            continue
        reported = motion.torque[:, i] * effort_per_reported(joint, motion.quantity[i], robot.name)
        given = as_given(joint, reported, motion, place[:, i])
        if OBSERVERS[observer] is None:
            # Through the filter that accelerations come from: what jumps in the effort alone is none of the friction.
            given = smooth_derivatives(motion, given)[0]
        left = given - (effort.total[:, i] - effort.friction[:, i])
        friction, velocity = _observed(OBSERVERS[observer], joint, motion, i, float(mass[i]), left, bandwidth)
        for name, values in (("friction", friction), (VELOCITY, velocity)):
            columns[f"{name}.{joint.name}"] = log.as_recorded(back_to_log(motion, log, values))
    if len(columns) == 1:
        raise LogError(f"{log.source}: no joint of '{robot.name}' has an effort or a current; friction needs one")
    return columns


def _observed(
    make: Maker | None, joint: Joint, motion: Motion, index: int, mass: float, left: Floats, bandwidth: float
) -> tuple[Floats, Floats]:
    # ``left`` is the drive's effort less everything that the robot needs apart from friction, including inertia.  The
    # observer accounts for the mass itself, so m·a is added back to get the force on it.
    if make is None:
        return left, motion.velocity[:, index]
    step, rate = 1.0 / motion.rate, 2.0 * np.pi * bandwidth
    force = left + mass * motion.acceleration[:, index]
    own = make(joint, mass, step, rate, max(float(np.max(np.abs(force))), 1e-9))
    friction, velocity = np.full(force.size, np.nan), np.full(force.size, np.nan)
    for piece in motion.pieces:
        estimates = estimate_along(
            own, step, motion.position[piece, index], force[piece], motion.velocity[piece, index]
        )
        settling = int(SETTLED / rate * motion.rate)
        for values, found in zip((friction, velocity), estimates, strict=True):
            found[:settling] = np.nan
            values[piece] = found
    return friction, velocity
