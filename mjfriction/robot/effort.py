"""What a robot says its drives would report along a motion: the balance of the model, joint by joint.

effort = rnea(q, q̇, q̈) + rotor_inertia·gear_ratio²·q̈ + friction(q̇, q, …) + cogging(q) + spring(q) + coupling
reported = scale·effort(t − delay) + offset,      current = reported / (gear_ratio·torque_constant)

q being where the links are: what the sensors read, less their offsets, less what the transmissions give.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from mjfriction.body.inverse import inertia_along, inverse_dynamics
from mjfriction.body.model import Body
from mjfriction.errors import RobotError
from mjfriction.laws.ambient import ROOM_TEMPERATURE, ambient
from mjfriction.laws.law import Floats
from mjfriction.record.log import CURRENT
from mjfriction.record.motion import Motion, smooth_derivatives
from mjfriction.robot.robot import Robot
from mjfriction.robot.schema import FrictionTerm, Joint, Wave
from mjfriction.robot.transmission import lag

GIVING_ROUNDS = 2  # enough for what gives a few percent of the motion
SURE = 3.0  # deviations of the velocity's noise beyond which the direction of motion is known


@dataclass(frozen=True)
class Effort:
    """Predicted effort along a motion, each of shape (n, joints), N·m or N at the joint.

    ``rigid``: links, payload, gravity and rotors; ``friction``; ``total``: these with cogging and springs;
    ``reported``: what the drive's sensor would say.
    """

    rigid: Floats
    friction: Floats
    total: Floats
    reported: Floats


def predict_effort(robot: Robot, body: Body, motion: Motion) -> Effort:
    """Predict the effort of every joint along a motion, as its sensors saw it.

    At rest friction is not known from the motion; :func:`direction` says what is taken.
    """
    motor = without_offsets(robot, motion)
    linked = link_motion(robot, body, motor)
    rigid = inverse_dynamics(body, linked.position, linked.velocity, linked.acceleration)
    # Rotors turn with the sensor, not with the link.
    rigid += body.armature * (motor.acceleration - linked.acceleration)
    rubbing = _where_friction_acts(robot, motor, linked)
    friction = friction_along(robot, rubbing, rigid)
    total, reported = np.empty_like(rigid), np.empty_like(rigid)
    for i, joint in enumerate(robot.table.joint):
        spring = joint.spring.stiffness * linked.position[:, i] + joint.spring.preload
        total[:, i] = rigid[:, i] + friction[:, i] + _waves(joint.cogging, motor.position[:, i]) + spring
    alone = total.copy()
    for i, joint in enumerate(robot.table.joint):
        for coupling in joint.coupling:
            other = robot.joints.index(coupling.joint)
            total[:, i] += coupling.coulomb * forward_share(rubbing, other)
            total[:, i] += coupling.viscous * rubbing.velocity[:, other] + coupling.effort * alone[:, other]
        seen = _late(total[:, i], motion, joint.effort_sensor.delay)
        reported[:, i] = joint.effort_sensor.scale * seen + joint.effort_sensor.offset
    return Effort(rigid, friction, total, reported)


def without_offsets(robot: Robot, motion: Motion) -> Motion:
    """Return where the sensors' joints are: what they read, less their offsets."""
    offset = np.array([joint.position_sensor.offset for joint in robot.table.joint])
    return replace(motion, position=motion.position - offset) if np.any(offset) else motion


def _where_friction_acts(robot: Robot, motor: Motion, linked: Motion) -> Motion:
    behind = np.array([joint.transmission.carries_friction for joint in robot.table.joint])
    if not np.any(behind):
        return motor
    position, velocity = (
        np.where(behind, b, a) for a, b in ((motor.position, linked.position), (motor.velocity, linked.velocity))
    )
    return replace(motor, position=position, velocity=velocity)


def friction_along(robot: Robot, motion: Motion, rigid: Floats) -> Floats:
    """Return the friction of every joint along a motion of the links that needs ``rigid``, both (n, joints)."""
    friction = np.zeros_like(rigid)
    for i, joint in enumerate(robot.table.joint):
        around = surroundings(joint, motion, i, rigid[:, i])
        for term in joint.friction or ():
            friction[:, i] += term_torque(term, joint.actuator.gear_ratio, motion, i, around)
        friction[:, i] += varying_friction(joint, motion, i, forward_share(motion, i))
        for drive in joint.common_drive:
            other = robot.joints.index(drive.joint)
            turn = motion.velocity[:, i] + drive.ratio * motion.velocity[:, other]
            noise = float(np.hypot(motion.velocity_noise[i], drive.ratio * motion.velocity_noise[other]))
            share, _ = direction(turn, noise)
            rub = drive.coulomb * (2.0 * share - 1.0) + drive.viscous * turn
            friction[:, i] += rub
            friction[:, other] += drive.ratio * rub
    return friction


def link_motion(robot: Robot, body: Body, motion: Motion) -> Motion:
    """Return the motion of the links behind the motors' motion: what the transmissions give is taken off.

    The load on a transmission is what the link needs along its own motion, found in rounds from the motors'.
    """
    if not any(joint.transmission.compliance or joint.transmission.backlash for joint in robot.table.joint):
        return motion
    inertia = inertia_along(body, motion.position)
    linked = motion
    for _ in range(GIVING_ROUNDS):
        load = inverse_dynamics(body, linked.position, linked.velocity, linked.acceleration)
        friction = friction_along(robot, linked, load)
        load -= body.armature * linked.acceleration
        parts = [motion.position.copy(), motion.velocity.copy(), motion.acceleration.copy()]
        for i, joint in enumerate(robot.table.joint):
            if joint.transmission.compliance or joint.transmission.backlash:
                carried = load[:, i] + friction[:, i] if joint.transmission.carries_friction else load[:, i]
                behind = lag(joint.transmission, motion, carried, inertia[:, i])
                for part, derivative in zip(parts, smooth_derivatives(motion, behind), strict=True):
                    part[:, i] -= derivative
        linked = replace(motion, position=parts[0], velocity=parts[1], acceleration=parts[2])
    return linked


def forward_share(motion: Motion, index: int) -> Floats:
    """Return the direction of friction on a joint, −1 to 1, between the two while it may be stuck, (n,)."""
    forward, _ = direction(motion.velocity[:, index], motion.velocity_noise[index])
    return 2.0 * forward - 1.0


def varying_friction(joint: Joint, motion: Motion, index: int, forward: Floats) -> Floats:
    """Return what varies the friction of a joint along the stroke, with temperature, time and pressure, (n,).

    ``forward`` (n,) is the direction of friction.
    """
    velocity, time = motion.velocity[:, index], motion.time
    level, rate = _waves(joint.friction_waves, motion.position[:, index]), np.zeros_like(velocity)
    thermal = joint.thermal
    if thermal.coulomb_per_kelvin or thermal.viscous_per_kelvin:
        warmer = motion.columns.get(f"temperature.{joint.name}", ROOM_TEMPERATURE) - thermal.reference_temperature
        level, rate = level + thermal.coulomb_per_kelvin * warmer, rate + thermal.viscous_per_kelvin * warmer
    if joint.warm_up is not None:
        share = warmed(time, joint.warm_up.time_constant)
        level, rate = level + joint.warm_up.coulomb * share, rate + joint.warm_up.viscous * share
    for event in joint.events:
        after = time >= event.time
        level, rate = level + event.coulomb * after, rate + event.viscous * after
    pressed = joint.pressure_friction
    for name, per_pascal in (("pressure_head", pressed.head), ("pressure_rod", pressed.rod)):
        if per_pascal:
            level = level + per_pascal * motion.columns.get(f"{name}.{joint.name}", 0.0)
    return np.asarray(level * forward + rate * velocity)


def warmed(time: Floats, time_constant: float) -> Floats:
    """Return 1 − e^(−t/τ), the share of a warm-up that is over; none before time zero."""
    return np.asarray(-np.expm1(-np.maximum(time, 0.0) / time_constant))


def _late(effort: Floats, motion: Motion, delay: float) -> Floats:
    if delay == 0.0:
        return effort
    out = np.empty_like(effort)
    for piece in np.unique(motion.piece):
        own = motion.piece == piece
        out[own] = np.interp(motion.time[own] - delay, motion.time[own], effort[own])
    return out


def _waves(waves: tuple[Wave, ...], position: Floats) -> Floats:
    out = np.zeros_like(position)
    for wave in waves:
        out += wave.cosine * np.cos(wave.wavenumber * position) + wave.sine * np.sin(wave.wavenumber * position)
    return out


def surroundings(joint: Joint, motion: Motion, index: int, load: Floats) -> Floats:
    """Return what the joint's friction may read along a motion, shape (n, 6); room temperature where none is logged."""

    def column(name: str, otherwise: float) -> Floats | float:
        return motion.columns.get(f"{name}.{joint.name}", otherwise)

    return ambient(
        load.size,
        load=load,
        position=motion.position[:, index],
        temperature=column("temperature", ROOM_TEMPERATURE),
        pressure_head=column("pressure_head", 0.0),
        pressure_rod=column("pressure_rod", 0.0),
    )


def term_torque(term: FrictionTerm, gear_ratio: float, motion: Motion, index: int, around: Floats) -> Floats:
    """Return one friction law's torque at the joint along a motion, shape (n,).

    ``around`` (n, 6) is what surrounds the joint.  A law with a state is followed sample by sample, from rest at the
    start of every piece; one without takes the direction of :func:`direction`.
    """
    friction = term.friction(gear_ratio)
    velocity = motion.velocity[:, index]
    if friction.state_count == 0:
        forward, speed = direction(velocity, motion.velocity_noise[index])
        return forward * friction.steady(speed, around) + (1.0 - forward) * friction.steady(-speed, around)
    out = np.empty_like(velocity)
    for piece in np.unique(motion.piece):
        own = motion.piece == piece
        out[own] = friction.follow(velocity[own], around[own], 1.0 / motion.rate)[0]
    return out


def direction(velocity: Floats, noise: float) -> tuple[Floats, Floats]:
    """Return how far friction points against forward motion, 0 to 1, and the joint's speed (never quite 0), each (n,).

    Where the velocity is within three deviations of its noise the joint may be stuck.  Friction then passes from its
    value before to its value after as the drive pulls over, taken as evenly in time; before the first and after the
    last motion it is taken as none.
    """
    tiny = max(noise, 1e-12)
    sure = np.abs(velocity) > SURE * tiny
    if not np.any(sure):
        return np.full(velocity.size, 0.5), np.maximum(np.abs(velocity), tiny)
    sample = np.arange(velocity.size)
    forward = np.interp(sample, sample[sure], (velocity[sure] > 0.0).astype(np.float64), left=0.5, right=0.5)
    return forward, np.maximum(np.abs(velocity), tiny)


def reported_unit(quantity: str | None, sliding: bool) -> str:
    """Return the unit of a joint's reported quantity."""
    return "A" if quantity == CURRENT else ("N" if sliding else "N·m")


def effort_per_reported(joint: Joint, quantity: str | None, robot_name: str) -> float:
    """Return what turns a log's reported quantity into effort at the joint: 1, or N·m per ampere.

    Raises :class:`RobotError` when the log has currents and the robot no torque constant.
    """
    if quantity != CURRENT:
        return 1.0
    if joint.actuator.torque_constant is None:
        raise RobotError(
            f"robot '{robot_name}', joint '{joint.name}': the log has current.{joint.name} but the robot file no "
            "actuator.torque_constant (N·m/A at the motor); add it"
        )
    return joint.actuator.gear_ratio * joint.actuator.torque_constant
