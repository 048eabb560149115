"""What a robot says its drives would report along a motion: the balance of the model, joint by joint.

effort = rnea(q, q̇, q̈) + rotor_inertia·gear_ratio²·q̈ + friction(q̇, q, …) + cogging(q) + spring(q) + coupling
reported = scale·effort(t − delay)/(1 + ripple(q)) + offset,      current = reported / (gear_ratio·torque_constant)

the effort low-passed where the drive's bandwidth is stated, q being where the links are: what the sensors read, less
their offsets, less what the transmissions give.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from mjfriction.body.inverse import inertia_along, motion_derivatives
from mjfriction.body.model import Body
from mjfriction.errors import RobotError
from mjfriction.laws.law import Floats
from mjfriction.record.log import CURRENT
from mjfriction.record.motion import Motion, smooth_derivatives
from mjfriction.robot.links_torque import links_torque
from mjfriction.robot.robot import Robot
from mjfriction.robot.rubbing import forward_share, friction_along, states_along, waves_along
from mjfriction.robot.schema import EffortSensor, Joint
from mjfriction.robot.spring import spring_along
from mjfriction.robot.transmission import Link, lag

GIVING_ROUNDS = 2  # enough for what gives a few percent of the motion
POSES = 50.0  # Hz: between two of these no joint turns far enough for its inertia to bend


@dataclass(frozen=True)
class Loads:
    """What links and rotors take along a motion, each of shape (n, joints), N·m or N at the joint.

    ``rigid``: links, payload, gravity and rotors; ``rotor``: the part of each drive's own rotor in that.
    """

    rigid: Floats
    rotor: Floats

    @functools.cached_property
    def load(self) -> Floats:
        """What passes the transmissions to the links, (n, joints): the load that friction may grow with."""
        return self.rigid - self.rotor


@dataclass(frozen=True)
class Effort(Loads):
    """Predicted effort along a motion: ``friction`` besides what links and rotors take; ``total``: these with cogging
    and springs; ``reported``: what the drive's sensor would say, each (n, joints), N·m or N.
    """

    friction: Floats
    total: Floats
    reported: Floats


@dataclass(frozen=True)
class Carried(Loads):
    """What the drives carry along a motion: what links and rotors take, the ``motor``'s motion, that of where the links
    are (``linked``) and of where friction acts (``rubbing``).
    """

    motor: Motion
    linked: Motion
    rubbing: Motion


def predict_effort(robot: Robot, body: Body, motion: Motion) -> Effort:
    """Predict the effort of every joint along a motion, as its sensors saw it.

    At rest friction is not known from the motion; :func:`~mjfriction.robot.rubbing.direction` says what is taken.
    """
    return effort_of(robot, motion, carry(robot, body, motion))


def effort_of(robot: Robot, motion: Motion, carried: Carried) -> Effort:
    """Return the effort of a robot whose links and rotors are ``carried`` along the motion."""
    motor, linked, rubbing, rigid = carried.motor, carried.linked, carried.rubbing, carried.rigid
    friction = friction_along(robot, rubbing, carried.load, carried.rotor)
    total = np.empty_like(rigid)
    for i, joint in enumerate(robot.table.joint):
        spring = spring_along(joint.spring, linked.position[:, i])
        total[:, i] = rigid[:, i] + friction[:, i] + waves_along(joint.cogging, motor.position[:, i]) + spring
    alone = total.copy()
    for i, joint in enumerate(robot.table.joint):
        for coupling in joint.coupling:
            other = robot.joints.index(coupling.joint)
            total[:, i] += coupling.coulomb * forward_share(rubbing, other)
            total[:, i] += coupling.viscous * rubbing.velocity[:, other]
            total[:, i] += coupling.inertia * motor.acceleration[:, other]
            if coupling.effort:
                total[:, i] += coupling.effort * shared_effort(robot, motion, other, alone[:, other])
    return Effort(rigid, carried.rotor, friction, total, reported_of(robot, motion, total))


def reported_of(robot: Robot, motion: Motion, total: Floats) -> Floats:
    """Return what the drives' sensors say of torques (n, joints) along a motion, their offsets included."""
    position = without_offsets(robot, motion).position
    seen = [as_reported(joint, total[:, i], motion, position[:, i]) for i, joint in enumerate(robot.table.joint)]
    return np.asarray(np.column_stack(seen) + [joint.effort_sensor.offset for joint in robot.table.joint])


def unheard(robot: Robot) -> Robot:
    """Return the robot with effort sensors that do nothing, but for those whose word other joints' torques depend on:
    robots that are equal so need the same torques.
    """
    shared = {coupling.joint for joint in robot.table.joint for coupling in joint.coupling if coupling.effort}
    joints = tuple(
        joint if joint.name in shared else joint.model_copy(update={"effort_sensor": EffortSensor()})
        for joint in robot.table.joint
    )
    return replace(robot, table=robot.table.model_copy(update={"joint": joints}))


def bare(robot: Robot) -> Robot:
    """Return the robot with what its links, rotors and transmissions need and no more: robots that are equal so carry
    the same.  Where friction acts behind what gives, it is the robot itself.
    """
    if any(joint.transmission.carries_friction for joint in robot.table.joint):
        return robot
    joints = tuple(
        Joint(
            name=joint.name,
            top_speed=joint.top_speed,
            actuator=joint.actuator,
            common_drive=joint.common_drive,
            transmission=joint.transmission,
            position_sensor=joint.position_sensor,
        )
        for joint in robot.table.joint
    )
    return replace(robot, table=robot.table.model_copy(update={"joint": joints}))


def shared_effort(robot: Robot, motion: Motion, joint: int, predicted: Floats) -> Floats:
    """Return the effort (n,) that a joint shares with others: as its drive reported it, where it did, else as
    ``predicted``.

    A joint that sticks carries what its drive gives, which its motion does not tell.
    """
    table, reported = robot.table.joint[joint], motion.torque[:, joint]
    if not np.all(np.isfinite(reported)):
        return predicted
    worth = effort_per_reported(table, motion.quantity[joint], robot.name)
    return as_given(table, reported * worth, motion, motion.position[:, joint] - table.position_sensor.offset)


def friction_states(robot: Robot, body: Body, motion: Motion) -> dict[str, dict[str, Floats]]:
    """Return what friction's states are along a motion as its sensors saw it: by joint and law, (n, states)."""
    carried = carry(robot, body, motion)
    return states_along(robot, carried.rubbing, carried.load, carried.rotor)


def carry(robot: Robot, body: Body, motion: Motion) -> Carried:
    """Return what a robot's drives carry along a motion as its sensors saw it."""
    motor = without_offsets(robot, motion)
    linked = link_motion(robot, body, motor)
    rigid = links_torque(robot, body, linked)
    # Rotors turn with the sensor, not with the link.
    rotor = body.armature * motor.acceleration
    rigid += rotor - body.armature * linked.acceleration
    for i, joint in enumerate(robot.table.joint):
        for drive in joint.common_drive:
            other = robot.joints.index(drive.joint)
            turned = drive.inertia * (motor.acceleration[:, i] + drive.ratio * motor.acceleration[:, other])
            rigid[:, i] += turned
            rigid[:, other] += drive.ratio * turned
    return Carried(rigid, rotor, motor, linked, _where_friction_acts(robot, motor, linked))


def as_reported(joint: Joint, torque: Floats, motion: Motion, position: Floats) -> Floats:
    """Return what a drive's sensor makes of torques at its joint, (n, ...), all but its offset.

    They are worth more or less current by the drive's ripple at its own ``position`` (n,), come late, are low-passed,
    and are scaled.
    """
    if joint.actuator.ripple:
        worth = 1.0 / (1.0 + waves_along(joint.actuator.ripple, position))
        torque = torque * worth.reshape(-1, *[1] * (torque.ndim - 1))
    sensor = joint.effort_sensor
    seen = delayed(torque, motion, sensor.delay)
    return np.asarray(sensor.scale * (seen if sensor.bandwidth is None else motion.low_passed(seen, sensor.bandwidth)))


def as_given(joint: Joint, reported: Floats, motion: Motion, position: Floats) -> Floats:
    """Return the torques (n,) that a drive gave when its sensor reported these: what :func:`as_reported` does, undone,
    but for what a low-pass has taken.

    ``position`` (n,) is the drive's own.
    """
    sensor = joint.effort_sensor
    given = delayed((reported - sensor.offset) / sensor.scale, motion, -sensor.delay)
    return np.asarray(given * (1.0 + waves_along(joint.actuator.ripple, position)))


def without_offsets(robot: Robot, motion: Motion) -> Motion:
    """Return where the sensors' joints are: what they read, less their offsets."""
    offset = np.array([joint.position_sensor.offset for joint in robot.table.joint])
    return replace(motion, position=motion.position - offset) if np.any(offset) else motion


def _where_friction_acts(robot: Robot, motor: Motion, linked: Motion) -> Motion:
    transmissions = [joint.transmission for joint in robot.table.joint]
    behind = np.array([own.carries_friction or own.rubs_with_link for own in transmissions])
    if not np.any(behind):
        return motor
    position, velocity = (
        np.where(behind, b, a) for a, b in ((motor.position, linked.position), (motor.velocity, linked.velocity))
    )
    return replace(motor, position=position, velocity=velocity)


def link_motion(robot: Robot, body: Body, motion: Motion) -> Motion:
    """Return the motion of the links behind the motors' motion: what the transmissions give is taken off.

    The load on a transmission is what the link needs along its own motion, found in rounds from the motors'.
    """
    transmissions = [
        joint.transmission.jump_free if i in motion.jump_free else joint.transmission
        for i, joint in enumerate(robot.table.joint)
    ]
    if not any(transmission.gives for transmission in transmissions):
        return motion
    inertia = _at_poses(motion, functools.partial(inertia_along, body))
    coasts = any(transmission.backlash and transmission.coasting for transmission in transmissions)
    stiffness = _at_poses(motion, functools.partial(_stiffness_along, body)) if coasts else np.zeros_like(inertia)
    rubbed = np.array([joint.transmission.carries_friction for joint in robot.table.joint])
    behind = np.zeros_like(inertia)
    linked = motion
    for _ in range(GIVING_ROUNDS):
        rotor = body.armature * linked.acceleration
        carried = links_torque(robot, body, linked) - rotor
        if np.any(rubbed):
            carried += rubbed * friction_along(robot, linked, carried, rotor)
        parts = [motion.position.copy(), motion.velocity.copy(), motion.acceleration.copy()]
        for i, transmission in enumerate(transmissions):
            if transmission.gives:
                ahead = motion.acceleration[:, i] - linked.acceleration[:, i]
                following = carried[:, i] + inertia[:, i] * ahead
                link = Link(carried[:, i], behind[:, i], following, inertia[:, i], stiffness[:, i])
                behind[:, i] = lag(transmission, motion, link)
                for part, derivative in zip(parts, smooth_derivatives(motion, behind[:, i]), strict=True):
                    part[:, i] -= derivative
        linked = replace(motion, position=parts[0], velocity=parts[1], acceleration=parts[2])
    return linked


def _at_poses(motion: Motion, told: Callable[[Floats], Floats]) -> Floats:
    # What changes with the pose, (n, joints), and so no faster than a joint goes from one pose to another.
    count, change = motion.time.size, np.flatnonzero(np.diff(motion.piece))
    every = np.arange(0, count, max(1, int(motion.rate / POSES)))
    some = np.unique([*every, *change, *(change + 1), count - 1])
    return np.column_stack([np.interp(np.arange(count), some, own) for own in told(motion.position[some]).T])


def _stiffness_along(body: Body, position: Floats) -> Floats:
    # How the load of each joint that stands still grows with its own position, (n, joints).
    still = np.zeros_like(position)
    return np.diagonal(motion_derivatives(body, position, still, still)[0], axis1=1, axis2=2)


def later(joint: Joint, delay: float) -> Joint:
    """Return a joint whose drive reports its effort so much later (s)."""
    sensor = joint.effort_sensor.model_copy(update={"delay": joint.effort_sensor.delay + delay})
    return joint.model_copy(update={"effort_sensor": sensor}) if delay else joint


def delayed(effort: Floats, motion: Motion, delay: float) -> Floats:
    """Return what was there so much earlier (s) of (n, ...) along a motion, its pieces apart.

    Between samples it runs straight, before the first of a piece and after the last it stays as it was there.
    """
    if delay == 0.0:
        return effort
    whole, between = divmod(delay * motion.rate, 1.0)
    out = np.empty_like(effort)
    for own in motion.pieces:
        course = effort[own]
        later_still = _moved(course, int(whole) + 1) if between else course
        out[own] = (1.0 - between) * _moved(course, int(whole)) + between * later_still
    return out


def _moved(course: Floats, samples: int) -> Floats:
    # A course (n, ...) so many samples later, or earlier, held at its ends.
    if samples == 0:
        return course
    count = min(abs(samples), course.shape[0])
    held = np.broadcast_to(course[0 if samples > 0 else -1], (count, *course.shape[1:]))
    return np.concatenate([held, course[:-count]] if samples > 0 else [course[count:], held])


def reported_unit(quantity: str | None, sliding: bool) -> str:
    """Return the unit of a joint's reported quantity."""
    return "A" if quantity == CURRENT else ("N" if sliding else "N·m")


def effort_per_reported(joint: Joint, quantity: str | None, robot_name: str) -> float:
    """Return what turns a log's reported quantity into effort at the joint: 1, or N·m per ampere.

    Raises :class:`RobotError` when the log has currents and the robot no torque constant.
    """
    if quantity != CURRENT:
        return 1.0
    worth = joint.actuator.effort_per_ampere
    if worth is None:
        raise RobotError(
            f"robot '{robot_name}', joint '{joint.name}': the log has current.{joint.name} but the robot file no "
            "actuator.torque_constant (N·m/A at the motor); add it"
        )
    return worth
