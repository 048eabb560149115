"""Friction along a log, joint by joint, as an observer estimates it: what drive and motion say, without a law."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from mjfriction.body.inverse import inertia_along
from mjfriction.control.bristle_observer import BristleObserver
from mjfriction.control.disturbance import DisturbanceObserver
from mjfriction.control.friedland import FriedlandMentzelopoulou, FriedlandPark, Tafazoli
from mjfriction.control.observer import Observer, estimate_along
from mjfriction.control.variable_structure import VariableStructure
from mjfriction.errors import ControlError, LogError, suggestion
from mjfriction.laws.law import Floats
from mjfriction.record.log import VELOCITY, Log, check_joints
from mjfriction.record.motion import back_to_log, estimate_motion
from mjfriction.robot.bandwidth import choose_cutoff
from mjfriction.robot.effort import effort_per_reported, predict_effort
from mjfriction.robot.robot import Robot
from mjfriction.robot.schema import Joint
from mjfriction.robot.simulation import joint_laws

USUAL_BANDWIDTH = 10.0  # Hz
SLIDING_STEPS = 3.0  # steps within which the smooth switching takes a position's error up
SURE = 3.0  # times the velocity error that all of the force unexplained would make, for the switching to be above it

Maker = Callable[[Joint, float, float, float, float], Observer]
"""(joint, mass, step, rate in rad/s, largest force) → an observer whose errors die away at about that rate."""


def _bristle(joint: Joint, mass: float, step: float, rate: float, force: float) -> Observer:
    del step, force
    laws = [law for law in joint_laws(joint) if law.state_count == 1]
    if len(laws) != 1 or len(joint.friction or ()) != 1:
        raise ControlError(
            f"joint '{joint.name}': the bristle observer goes by the joint's one law with a bristle, such as 'lugre'; "
            "state it in the robot file, or take another observer"
        )
    stiffness = laws[0].law.unpack(laws[0].values)["bristle_stiffness"]
    assert isinstance(stiffness, float)
    # e_v' = −σ₀·e_z/m − l·e_v, e_z' = γ·e_v: both rates equal to the one asked for.
    return BristleObserver(mass, laws[0], 2.0 * rate, mass * rate * rate / (stiffness * laws[0].gear_ratio ** 2))


def _sliding(joint: Joint, mass: float, step: float, rate: float, force: float) -> Observer:
    del joint
    switching = SURE * force / (mass * rate)
    return VariableStructure.with_rate(mass, rate, switching, SLIDING_STEPS * switching * step)


OBSERVERS: dict[str, Maker] = {
    "disturbance": lambda _, mass, step, rate, __: DisturbanceObserver.with_bandwidth(mass, step, rate / (2.0 * np.pi)),
    "friedland_park": lambda _, mass, __, rate, ___: FriedlandPark(mass, rate),
    "friedland_mentzelopoulou": lambda _, mass, __, rate, ___: FriedlandMentzelopoulou(mass, rate, 2.0 * rate),
    "tafazoli": lambda _, mass, __, rate, ___: Tafazoli(mass, rate, 2.0 * rate),
    "variable_structure": _sliding,
    "bristle": _bristle,
}
"""The observers by name, each made from one bandwidth."""


def observe_log(
    log: Log, robot: Robot, observer: str = "disturbance", bandwidth: float = USUAL_BANDWIDTH
) -> dict[str, Floats]:
    """Return ``time`` and, for every joint with an effort or a current, ``friction.<joint>`` and ``velocity.<joint>``.

    N·m and rad/s at the joint (N, m/s).  The rest of the robot is believed: links, gravity, rotors, cogging, springs.
    What the joint's mass changes along the motion, and what other joints do to it, stands with what pushes it.  Rows
    are those of the log's file, NaN where a row was left out.

    Raises :class:`ControlError` for an observer that there is not or that cannot work on this log;
    :class:`~mjfriction.errors.LogError`, :class:`~mjfriction.errors.RobotError` where log or robot cannot be used.
    """
    if observer not in OBSERVERS:
        raise ControlError(
            f"there is no observer '{observer}'{suggestion(observer, OBSERVERS)} There are {', '.join(OBSERVERS)}"
        )
    if not bandwidth > 0.0:
        raise ControlError(f"bandwidth = {bandwidth:g} Hz; allowed is above 0")
    body = robot.body()
    robot = robot.with_stated_friction(body)
    check_joints(log, robot.name, robot.joints)
    motion = estimate_motion(log, robot.joints, choose_cutoff(log, robot, body))
    effort = predict_effort(robot, body, motion)
    mass = np.mean(inertia_along(body, motion.position), axis=0) + body.armature
    columns = {"time": log.time if log.recorded is None else log.recorded}
    step = 1.0 / motion.rate
    for i, joint in enumerate(robot.table.joint):
        if motion.quantity[i] is None:
            continue
        drive = motion.torque[:, i] * effort_per_reported(joint, motion.quantity[i], robot.name)
        drive = (drive - joint.effort_sensor.offset) / joint.effort_sensor.scale
        # All that stands against the drive but friction and the mass that the observer knows.
        force = drive - (effort.total[:, i] - effort.friction[:, i]) + mass[i] * motion.acceleration[:, i]
        largest = max(float(np.max(np.abs(force))), 1e-9)
        own = OBSERVERS[observer](joint, float(mass[i]), step, 2.0 * np.pi * bandwidth, largest)
        friction, velocity = np.full(force.size, np.nan), np.full(force.size, np.nan)
        for piece in motion.pieces:
            friction[piece], velocity[piece] = estimate_along(
                own, step, motion.position[piece, i], force[piece], motion.velocity[piece, i]
            )
        for name, values in (("friction", friction), (VELOCITY, velocity)):
            columns[f"{name}.{joint.name}"] = log.as_recorded(back_to_log(motion, log, values))
    if len(columns) == 1:
        raise LogError(f"{log.source}: no joint of '{robot.name}' has an effort or a current; friction needs one")
    return columns
