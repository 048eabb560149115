"""Friction along a motion: every law, shared drives, and what varies with place, temperature, time and pressure."""

from __future__ import annotations

import numpy as np

from mjfriction.laws.ambient import ROOM_TEMPERATURE, ambient
from mjfriction.laws.law import Floats
from mjfriction.record.motion import Motion
from mjfriction.robot.robot import Robot
from mjfriction.robot.schema import FrictionTerm, Joint, Wave

SURE = 3.0  # deviations of the velocity's noise beyond which the direction of motion is known
RESTING = 0.5  # of the way that a joint turning at a steady acceleration would go, below which it rests


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


def forward_share(motion: Motion, index: int) -> Floats:
    """Return the direction of friction on a joint, −1 to 1, between the two while it may be stuck, (n,)."""
    forward, _ = direction(motion.velocity[:, index], motion.velocity_noise[index])
    return 2.0 * forward - 1.0


def varying_friction(joint: Joint, motion: Motion, index: int, forward: Floats) -> Floats:
    """Return what varies the friction of a joint along the stroke, with temperature, time and pressure, (n,).

    ``forward`` (n,) is the direction of friction.
    """
    velocity, time = motion.velocity[:, index], motion.time
    level, rate = waves_along(joint.friction_waves, motion.position[:, index]), np.zeros_like(velocity)
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


def waves_along(waves: tuple[Wave, ...], position: Floats) -> Floats:
    """Return the sum of waves along the stroke at positions (n,)."""
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


def term_torque(
    term: FrictionTerm,
    gear_ratio: float,
    motion: Motion,
    index: int,
    around: Floats,
    turned: tuple[Floats, Floats] | None = None,
) -> Floats:
    """Return one friction law's torque at the joint along a motion, shape (n,).

    ``around`` (n, 6) is what surrounds the joint.  A law with a state is followed sample by sample, from rest at the
    start of every piece; one without takes the direction of :func:`direction`, or ``turned``, where it is known.
    """
    friction = term.friction(gear_ratio)
    velocity = motion.velocity[:, index]
    if friction.state_count == 0:
        forward, speed = turned or direction(velocity, motion.velocity_noise[index])
        return forward * friction.steady(speed, around) + (1.0 - forward) * friction.steady(-speed, around)
    out = np.empty_like(velocity)
    for own in motion.pieces:
        out[own] = friction.follow(velocity[own], around[own], 1.0 / motion.rate)[0]
    return out


def direction(velocity: Floats, noise: float) -> tuple[Floats, Floats]:
    """Return how far friction points against forward motion, 0 to 1, and the joint's speed (never quite 0), each (n,).

    Where the velocity is within three deviations of its noise the joint may be stuck.  One that passes through that
    without pause turns somewhere between: friction then goes from its value before to its value after, taken as evenly
    in time.  One that rests may hold any friction within its level, of either direction: none is the best guess, as it
    is before the first and after the last motion.
    """
    tiny = max(noise, 1e-12)
    speed = np.maximum(np.abs(velocity), tiny)
    known = np.flatnonzero(np.abs(velocity) > SURE * tiny)
    if not known.size:
        return np.full(velocity.size, 0.5), speed
    sample = np.arange(velocity.size)
    forward = np.interp(sample, known, (velocity[known] > 0.0).astype(np.float64), left=0.5, right=0.5)
    for i in np.flatnonzero(np.diff(known) > 1):
        unsure = slice(known[i] + 1, known[i + 1])
        if _rests(velocity[unsure], SURE * tiny):
            forward[unsure] = 0.5
    return forward, speed


def _rests(velocity: Floats, sure: float) -> bool:
    # One that turns at a steady acceleration strays by a quarter of sure·samples, one that passes on by more; what
    # strays by less than half of that stays where it is.
    return bool(np.ptp(np.cumsum(velocity)) < RESTING * 0.25 * sure * velocity.size)
