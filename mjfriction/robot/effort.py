"""The effort that a robot's model predicts its drives to report along a motion, joint by joint.

effort = rnea(q, q̇, q̈) + rotor_inertia·gear_ratio²·q̈ + friction(q̇, q, …) + cogging(q) + spring(q) + coupling
reported = scale·effort(t − delay)/(1 + ripple(q)) + offset,      current = reported / (gear_ratio·torque_constant)

The effort is low-passed where the drive's bandwidth is stated.  Links and springs are taken at the link's position: the
sensor's reading less its offset and less the transmission's deflection and play.  Rotors, cogging and ripple are taken
at the motor's position, which has only the offset removed.  Friction acts on the motor's side unless the transmission
states otherwise.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass, replace

import numpy as np

from mjfriction.body.model import Body
from mjfriction.errors import RobotError
from mjfriction.laws.law import Floats
from mjfriction.record.log import CURRENT
from mjfriction.record.motion import Motion, smooth_derivatives
from mjfriction.robot.links_torque import links_torque
from mjfriction.robot.own_slopes import Slopes, own_slopes
from mjfriction.robot.robot import Robot
from mjfriction.robot.rubbing import forward_share, friction_along, states_along, waves_along
from mjfriction.robot.schema import EffortSensor, Joint
from mjfriction.robot.spring import coefficients, spring_along
from mjfriction.robot.transmission import LEAST_INERTIA, lag
from mjfriction.sim.lagging import Lagging

GIVING_ROUNDS = 2  # fixed-point rounds for the links' motion; enough if the deflection is a few percent of the motion


@dataclass(frozen=True)
class Loads:
    """The torques of links and rotors along a motion, each of shape (n, joints), N·m or N at the joint.

    ``rigid``: links, payload, gravity and rotors; ``rotor``: the part of that due to each drive's own rotor.
    """

    rigid: Floats
    rotor: Floats

    @functools.cached_property
    def load(self) -> Floats:
        """The torque that the transmissions pass to the links, (n, joints): the load that friction may grow with."""
        return self.rigid - self.rotor


@dataclass(frozen=True)
class Effort(Loads):
    """Predicted effort along a motion, each (n, joints), N·m or N.

    ``friction`` comes on top of the torques of links and rotors.  ``total`` is their sum with cogging, springs and
    couplings.  ``reported`` is what the drive's sensor would report.
    """

    friction: Floats
    total: Floats
    reported: Floats


@dataclass(frozen=True)
class Carried(Loads):
    """The torques of links and rotors along a motion, and the motions they are computed from.

    ``motor`` is the motion of the motors, ``linked`` that of the links, and ``rubbing`` that of the side on which
    friction acts.  ``sprung`` (n, joints) is the torque of the springs that the model file has.
    """

    motor: Motion
    linked: Motion
    rubbing: Motion
    sprung: Floats


def predict_effort(robot: Robot, body: Body, motion: Motion) -> Effort:
    """Predict the effort of every joint along a motion as its sensors recorded it.

    At rest, the motion does not determine friction; see :func:`~mjfriction.robot.rubbing.direction` for what is used.
    """
    return effort_of(robot, motion, carry(robot, body, motion))


def effort_of(robot: Robot, motion: Motion, carried: Carried) -> Effort:
    """Return the effort of a robot along a motion, given what its drives carry along it (:func:`carry`)."""
    motor, linked, rubbing, rigid = carried.motor, carried.linked, carried.rubbing, carried.rigid
    friction = friction_along(robot, rubbing, carried.load, carried.rotor)
    total = rigid + friction + carried.sprung
    for i, joint in enumerate(robot.table.joint):
        total[:, i] += waves_along(joint.cogging, motor.position[:, i])
        total[:, i] += spring_along(coefficients(joint.spring), linked.position[:, i])
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
    """Return what the drives' sensors report for torques (n, joints) along a motion, including their offsets."""
    position = without_offsets(robot, motion).position
    seen = [as_reported(joint, total[:, i], motion, position[:, i]) for i, joint in enumerate(robot.table.joint)]
    return np.asarray(np.column_stack(seen) + [joint.effort_sensor.offset for joint in robot.table.joint])


def unheard(robot: Robot) -> Robot:
    """Return the robot with its effort sensors reset to ideal ones, except those that torques depend on.

    Robots that are equal after this need the same torques.
    """
    shared = {coupling.joint for joint in robot.table.joint for coupling in joint.coupling if coupling.effort}
    shared |= {joint.name for joint in robot.table.joint if joint.transmission.swings}
    joints = tuple(
        joint if joint.name in shared else joint.model_copy(update={"effort_sensor": EffortSensor()})
        for joint in robot.table.joint
    )
    return replace(robot, table=robot.table.model_copy(update={"joint": joints}))


def bare(robot: Robot) -> Robot:
    """Return the robot reduced to what :func:`carry` depends on: robots that are equal after this carry the same.

    Where a transmission carries friction, or where it is told from the effort how a link swings at the beginning, its
    deflection depends on the friction too, and the robot is returned as is.
    """
    if any(joint.transmission.carries_friction or joint.transmission.swings for joint in robot.table.joint):
        return robot
    return _reduced(robot, "top_speed", "actuator", "common_drive", "transmission", "position_sensor")


def stiff(robot: Robot) -> Robot:
    """Return the robot reduced to what :func:`~mjfriction.robot.own_slopes.own_slopes` depends on.

    Robots that are equal after this have the same slopes.
    """
    return _reduced(robot, "actuator", "position_sensor")


def _reduced(robot: Robot, *tables: str) -> Robot:
    # The robot with some tables of each joint only.
    joints = tuple(
        Joint(name=joint.name, **{table: getattr(joint, table) for table in tables}) for joint in robot.table.joint
    )
    return replace(robot, table=robot.table.model_copy(update={"joint": joints}))


def shared_effort(robot: Robot, motion: Motion, joint: int, predicted: Floats) -> Floats:
    """Return the effort (n,) that a joint shares with others: as reported by its drive if complete, else ``predicted``.

    A sticking joint carries whatever torque its drive gives, which cannot be predicted from its motion.
    """
    given = given_along(robot, without_offsets(robot, motion), joint)
    return predicted if given is None else given


def given_along(robot: Robot, motor: Motion, joint: int) -> Floats | None:
    """Return the effort (n,) that a joint's drive gave as its sensor reported it, None where it did not all along.

    ``motor`` is the motion of the motors, without the position sensors' offsets.
    """
    table, reported = robot.table.joint[joint], motor.torque[:, joint]
    if not np.all(np.isfinite(reported)):
        return None
    worth = effort_per_reported(table, motor.quantity[joint], robot.name)
    return as_given(table, reported * worth, motor, motor.position[:, joint])


def friction_states(robot: Robot, body: Body, motion: Motion) -> dict[str, dict[str, Floats]]:
    """Return the friction states along a motion as its sensors recorded it: by joint and law, (n, states)."""
    carried = carry(robot, body, motion)
    return states_along(robot, carried.rubbing, carried.load, carried.rotor)


def carry(robot: Robot, body: Body, motion: Motion, slopes: Slopes = own_slopes) -> Carried:
    """Return what a robot's drives carry along a motion as its sensors recorded it.

    ``slopes`` returns what :func:`~mjfriction.robot.own_slopes.own_slopes` does.
    """
    motor = without_offsets(robot, motion)
    linked = link_motion(robot, body, motor, slopes)
    rigid = links_torque(robot, body, linked)
    # Rotors move with the sensor, not with the link.
    rotor = body.armature * motor.acceleration
    rigid += rotor - body.armature * linked.acceleration
    for i, joint in enumerate(robot.table.joint):
        for drive in joint.common_drive:
            other = robot.joints.index(drive.joint)
            turned = drive.inertia * (motor.acceleration[:, i] + drive.ratio * motor.acceleration[:, other])
            rigid[:, i] += turned
            rigid[:, other] += drive.ratio * turned
    courses = zip(body.spring, linked.position.T, strict=True)
    sprung = np.column_stack([spring_along(powers, position) for powers, position in courses])
    return Carried(rigid, rotor, motor, linked, _where_friction_acts(robot, motor, linked), sprung)


def as_reported(joint: Joint, torque: Floats, motion: Motion, position: Floats) -> Floats:
    """Return what a drive's sensor reports for torques at its joint, (n, ...), without its offset.

    The torques are divided by the ripple factor at the drive's ``position`` (n,), delayed, low-passed and scaled.
    """
    if joint.actuator.ripple:
        worth = 1.0 / (1.0 + waves_along(joint.actuator.ripple, position))
        torque = torque * worth.reshape(-1, *[1] * (torque.ndim - 1))
    sensor = joint.effort_sensor
    seen = delayed(torque, motion, sensor.delay)
    return np.asarray(sensor.scale * (seen if sensor.bandwidth is None else motion.low_passed(seen, sensor.bandwidth)))


def as_given(joint: Joint, reported: Floats, motion: Motion, position: Floats) -> Floats:
    """Return the torques (n,) that a drive gave when its sensor reported ``reported``: the inverse of its sensor.

    This undoes :func:`as_reported` and the offset, except for the low-pass.  ``position`` (n,) is the drive's own.
    """
    sensor = joint.effort_sensor
    given = delayed((reported - sensor.offset) / sensor.scale, motion, -sensor.delay)
    return np.asarray(given * (1.0 + waves_along(joint.actuator.ripple, position)))


def without_offsets(robot: Robot, motion: Motion) -> Motion:
    """Return the motion with the position sensors' offsets removed."""
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


def link_motion(robot: Robot, body: Body, motion: Motion, slopes: Slopes = own_slopes) -> Motion:
    """Return the motion of the links: the motors' motion less the transmissions' deflection and play.

    The load on a transmission is what the link needs along its own motion.  It is found by fixed-point iteration that
    starts from the motors' motion.  ``slopes`` is as for :func:`carry`.
    """
    transmissions = [
        joint.transmission.jump_free if i in motion.jump_free else joint.transmission
        for i, joint in enumerate(robot.table.joint)
    ]
    if not any(transmission.gives for transmission in transmissions):
        return motion
    changing = slopes(body, motion)
    rubbed = np.array([joint.transmission.carries_friction for joint in robot.table.joint])
    seen = _seen(robot, body, motion) if any(own.swings for own in transmissions) else {}
    linked = motion
    for _ in range(GIVING_ROUNDS):
        rotor = body.armature * linked.acceleration
        carried = links_torque(robot, body, linked) - rotor
        if np.any(rubbed):
            carried += rubbed * friction_along(robot, linked, carried, rotor)
        parts = [motion.position.copy(), motion.velocity.copy(), motion.acceleration.copy()]
        for i, transmission in enumerate(transmissions):
            if transmission.gives:
                link = _lagging(i, changing, carried, motion, linked)._replace(seen=seen.get(i))
                behind = lag(transmission, motion, carried[:, i], link)
                for part, derivative in zip(parts, smooth_derivatives(motion, behind), strict=True):
                    part[:, i] -= derivative
        linked = replace(motion, position=parts[0], velocity=parts[1], acceleration=parts[2])
    return linked


def _seen(robot: Robot, body: Body, motion: Motion) -> dict[int, Floats]:
    # What the drives of joints whose links swing were seen to pass on to them, (n,) each, if they report all along.
    rotor = body.armature * motion.acceleration
    carried = links_torque(robot, body, motion) - rotor
    friction = friction_along(robot, motion, carried, rotor)
    out = {}
    for i, joint in enumerate(robot.table.joint):
        if joint.transmission.swings and (given := given_along(robot, motion, i)) is not None:
            passed = given - rotor[:, i] - (0.0 if joint.transmission.carries_friction else friction[:, i])
            out[i] = in_motion(passed, motion, i)
    return out


def in_motion(effort: Floats, motion: Motion, joint: int) -> Floats:
    """Return an effort (n,), NaN where its joint may stick, so that nobody knows what friction takes of it."""
    return np.where(np.abs(motion.velocity[:, joint]) > motion.sure_speed[:, joint], effort, np.nan)


def _lagging(joint: int, slopes: Floats, carried: Floats, motion: Motion, linked: Motion) -> Lagging:
    # What a link would carry if it moved as its motor does, told from what it has ``carried`` along another motion.
    stiffness, damping, inertia = slopes[:, :, joint]
    load = carried[:, joint]
    for slope, course, own in (
        (stiffness, motion.position, linked.position),
        (damping, motion.velocity, linked.velocity),
        (inertia, motion.acceleration, linked.acceleration),
    ):
        load = load + slope * (course - own)[:, joint]
    return Lagging(load, np.maximum(inertia, LEAST_INERTIA), stiffness, damping)


def later(joint: Joint, delay: float) -> Joint:
    """Return the joint with its effort sensor's delay increased by ``delay`` (s)."""
    sensor = joint.effort_sensor.model_copy(update={"delay": joint.effort_sensor.delay + delay})
    return joint.model_copy(update={"effort_sensor": sensor}) if delay else joint


def delayed(effort: Floats, motion: Motion, delay: float) -> Floats:
    """Return values (n, ...) along a motion delayed by ``delay`` (s), each piece on its own.

    Values are interpolated linearly between samples and held constant beyond the ends of a piece.
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
    # Shift a course (n, ...) by a number of samples, later or (negative) earlier, holding the value at its end.
    if samples == 0:
        return course
    count = min(abs(samples), course.shape[0])
    held = np.broadcast_to(course[0 if samples > 0 else -1], (count, *course.shape[1:]))
    return np.concatenate([held, course[:-count]] if samples > 0 else [course[count:], held])


def reported_unit(quantity: str | None, sliding: bool) -> str:
    """Return the unit of a joint's reported quantity."""
    return "A" if quantity == CURRENT else ("N" if sliding else "N·m")


def effort_per_reported(joint: Joint, quantity: str | None, robot_name: str) -> float:
    """Return the factor from a log's reported quantity to effort at the joint: 1, or N·m (N) per ampere.

    Raises :class:`RobotError` if the log has currents but the robot file states no torque constant.
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
