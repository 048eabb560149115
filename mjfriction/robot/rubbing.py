"""Friction along a motion: all laws, shared drives, and variation with position, temperature, time and pressure."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mjfriction.laws.ambient import ROOM_TEMPERATURE, ambient
from mjfriction.laws.friction import CREEP, Friction
from mjfriction.laws.law import Floats
from mjfriction.record.log import HEAD_PRESSURE, ROD_PRESSURE
from mjfriction.record.motion import SURE, Motion
from mjfriction.robot.edges import edges_along
from mjfriction.robot.friction_tables import FrictionTerm
from mjfriction.robot.robot import Robot
from mjfriction.robot.schema import Joint
from mjfriction.robot.spots import spots_along
from mjfriction.robot.table import Wave

RESTING_SAMPLES = 200  # samples of a motion at which the level at rest is evaluated (at least, where it has as many)
MOST_SHARE = 0.9  # quantile of the level at rest over those samples
# A law's springs have forgotten their initial state after SLID times their yield travel; SLIDES steps simulate it.
SLID, SLIDES = 10.0, 200
UNSETTLED = 0.05  # friction is unsettled if the unknown initial state shifts it by more than this share of its level
# A joint rests if it strays less than this fraction of the distance of a reversal at constant acceleration.
RESTING = 0.5


def friction_along(robot: Robot, motion: Motion, load: Floats, rotor: Floats) -> Floats:
    """Return the friction of every joint along a motion, (n, joints).

    ``load`` and ``rotor`` (n, joints) are the torques of the links and of the drives' own rotors.
    """
    friction = np.zeros_like(load)
    for i, joint in enumerate(robot.table.joint):
        around = surroundings(joint, motion, i, load[:, i], rotor[:, i])
        for term in joint.friction or ():
            friction[:, i] += term_torque(term, joint.actuator.gear_ratio, motion, i, around)
        friction[:, i] += varying_friction(joint, motion, i, forward_share(motion, i))
        for drive in joint.common_drive:
            other = robot.joints.index(drive.joint)
            turn = motion.velocity[:, i] + drive.ratio * motion.velocity[:, other]
            share, _ = direction(turn, np.hypot(motion.sure_speed[:, i], drive.ratio * motion.sure_speed[:, other]))
            rub = drive.coulomb * (2.0 * share - 1.0) + drive.viscous * turn
            friction[:, i] += rub
            friction[:, other] += drive.ratio * rub
    return friction


def states_along(robot: Robot, motion: Motion, load: Floats, rotor: Floats) -> dict[str, dict[str, Floats]]:
    """Return the friction states along a motion by joint and law, (n, states).

    ``load`` and ``rotor`` (n, joints) are the torques of the links and of the drives' own rotors.  Where a joint has
    the same law twice, the states stand side by side.  Laws that :func:`term_torque` evaluates at their steady curve
    have no entry.
    """
    out: dict[str, dict[str, Floats]] = {}
    for i, joint in enumerate(robot.table.joint):
        around = surroundings(joint, motion, i, load[:, i], rotor[:, i])
        for term in joint.friction or ():
            friction = term.friction(joint.actuator.gear_ratio)
            if _followed(friction, motion, i):
                states = np.empty((motion.time.size, friction.state_count))
                for own in motion.pieces:
                    states[own] = friction.follow(motion.velocity[own, i], around[own], 1.0 / motion.rate)[1]
                own_states = out.setdefault(joint.name, {})
                before = own_states.get(term.law)
                own_states[term.law] = states if before is None else np.hstack([before, states])
    return out


def unsettled_along(robot: Robot, motion: Motion, load: Floats, rotor: Floats) -> NDArray[np.bool_]:
    """Return where a joint's friction still depends on the unknown initial state of a piece of the motion, (n, joints).

    True where starting with the springs undeflected, or deflected as after sliding in either direction, changes the
    friction by more than 5 % of its level.  ``load`` and ``rotor`` (n, joints) are those of :func:`friction_along`.
    """
    out = np.zeros(load.shape, dtype=bool)
    for i, joint in enumerate(robot.table.joint):
        around = surroundings(joint, motion, i, load[:, i], rotor[:, i])
        for term in joint.friction or ():
            friction = term.friction(joint.actuator.gear_ratio)
            if _followed(friction, motion, i) and np.isfinite(friction.travel):
                for own in motion.pieces:
                    out[own, i] |= _unsettled(friction, motion.velocity[own, i], around[own], 1.0 / motion.rate)
    return out


def _unsettled(friction: Friction, velocity: Floats, around: Floats, step: float) -> NDArray[np.bool_]:
    # Where friction is unsettled within one piece of the motion.
    out = np.zeros(velocity.size, dtype=bool)
    way = SLID * friction.travel
    until = slice(int(np.searchsorted(np.cumsum(np.abs(velocity)) * step, way)) + 1)
    slow = CREEP / abs(friction.gear_ratio)
    slides = [np.full(SLIDES, sign * slow) for sign in (1.0, -1.0)]
    starts = [friction.follow(own, np.repeat(around[:1], SLIDES, axis=0), way / SLIDES / slow)[1][-1] for own in slides]
    at_rest, *slid = (friction.follow(velocity[until], around[until], step, own)[0] for own in (None, *starts))
    off = np.max(np.abs(np.array(slid) - at_rest), axis=0)
    out[until] = off > UNSETTLED * friction.at_rest(around[:1], slow)
    return out


def _followed(friction: Friction, motion: Motion, index: int) -> bool:
    return friction.state_count > 0 and friction.travel > motion.travel_noise[index]


def resting_level(robot: Robot, motion: Motion, load: Floats, rotor: Floats, slow: Floats) -> Floats:
    """Return the friction that each joint may hold while its direction of motion is unknown, (joints,).

    This is the largest friction that its laws give at any speed below ``slow`` (joints,), as the 90 % quantile along
    the motion.  ``load`` and ``rotor`` (n, joints) are those of :func:`friction_along`.
    """
    out = np.zeros(len(robot.joints))
    some = slice(None, None, max(1, motion.time.size // RESTING_SAMPLES))
    for i, joint in enumerate(robot.table.joint):
        around = surroundings(joint, motion, i, load[:, i], rotor[:, i])[some]
        laws = [term.friction(joint.actuator.gear_ratio) for term in joint.friction or ()]
        level = sum((law.at_rest(around, float(slow[i])) for law in laws), np.zeros(around.shape[0]))
        varying = np.abs(varying_friction(joint, motion, i, np.ones(motion.time.size)))[some]
        out[i] += float(np.quantile(level + varying, MOST_SHARE))
        for drive in joint.common_drive:
            out[i] += drive.coulomb
            out[robot.joints.index(drive.joint)] += abs(drive.ratio) * drive.coulomb
    return out


def forward_share(motion: Motion, index: int) -> Floats:
    """Return the direction of friction on a joint, −1 to 1, with values in between while it may be stuck, (n,)."""
    forward, _ = direction(motion.velocity[:, index], motion.sure_speed[:, index])
    return 2.0 * forward - 1.0


def varying_friction(joint: Joint, motion: Motion, index: int, forward: Floats) -> Floats:
    """Return the friction of a joint that varies along the stroke, with temperature, time and pressure, (n,).

    ``forward`` (n,) is the direction of friction, −1 to 1.
    """
    velocity, time = motion.velocity[:, index], motion.time
    position = motion.position[:, index]
    level = waves_along(joint.friction_waves, position)
    level += spots_along(joint.friction_spots, position) + edges_along(joint.friction_edges, position)
    rate = np.zeros_like(velocity)
    thermal = joint.thermal
    if thermal.coulomb_per_kelvin or thermal.viscous_per_kelvin:
        warmer = motion.columns.get(f"temperature.{joint.name}", ROOM_TEMPERATURE) - thermal.reference_temperature
        level, rate = level + thermal.coulomb_per_kelvin * warmer, rate + thermal.viscous_per_kelvin * warmer
    if joint.warm_up is not None:
        share = warmed(time - joint.warm_up.begin, joint.warm_up.time_constant)
        level, rate = level + joint.warm_up.coulomb * share, rate + joint.warm_up.viscous * share
    for event in joint.events:
        after = time >= event.time
        level, rate = level + event.coulomb * after, rate + event.viscous * after
    pressed = joint.pressure_friction
    if pressed.head or pressed.rod or pressed.difference:
        head, rod = (motion.columns.get(f"{name}.{joint.name}", 0.0) for name in (HEAD_PRESSURE, ROD_PRESSURE))
        level = level + pressed.head * head + pressed.rod * rod + pressed.difference * np.abs(head - rod)
    return np.asarray(level * forward + rate * velocity)


def warmed(time: Floats, time_constant: float) -> Floats:
    """Return 1 − e^(−t/τ), the fraction of a warm-up completed after ``time`` (n,); 0 before it begins."""
    return np.asarray(-np.expm1(-np.maximum(time, 0.0) / time_constant))


def waves_along(waves: tuple[Wave, ...], position: Floats) -> Floats:
    """Return the sum of waves along the stroke at positions (n,)."""
    out = np.zeros_like(position)
    for wave in waves:
        out += wave.cosine * np.cos(wave.wavenumber * position) + wave.sine * np.sin(wave.wavenumber * position)
    return out


def wave_slopes_along(waves: tuple[Wave, ...], position: Floats) -> Floats:
    """Return the derivative of the sum of waves with respect to position, at positions (n,)."""
    turned = (
        Wave(wavenumber=wave.wavenumber, cosine=wave.wavenumber * wave.sine, sine=-wave.wavenumber * wave.cosine)
        for wave in waves
    )
    return waves_along(tuple(turned), position)


def surroundings(joint: Joint, motion: Motion, index: int, load: Floats, rotor: Floats) -> Floats:
    """Return the ambient quantities of a joint along a motion, (n, 7); room temperature where none is logged."""

    def column(name: str, otherwise: float) -> Floats | float:
        return motion.columns.get(f"{name}.{joint.name}", otherwise)

    return ambient(
        load.size,
        load=load,
        rotor=rotor,
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
    *,
    follow: bool = False,
) -> Floats:
    """Return one friction law's torque at the joint along a motion, shape (n,).

    ``around`` (n, 7) holds the ambient quantities of the joint.  A law with a state is simulated sample by sample, from
    rest at the start of every piece.  A law without a state is evaluated at its steady curve with the direction and
    speed of :func:`direction`, or with ``turned`` if given.  So is a law whose springs yield within the noise of the
    motion, since simulating it would only follow the noise.  With ``follow`` it is simulated all the same, so that the
    result is smooth in its parameters.
    """
    friction = term.friction(gear_ratio)
    velocity = motion.velocity[:, index]
    if not (_followed(friction, motion, index) or (follow and friction.state_count)):
        forward, speed = turned or direction(velocity, motion.sure_speed[:, index])
        return forward * friction.steady(speed, around) + (1.0 - forward) * friction.steady(-speed, around)
    out = np.empty_like(velocity)
    for own in motion.pieces:
        out[own] = friction.follow(velocity[own], around[own], 1.0 / motion.rate)[0]
    return out


def direction(velocity: Floats, sure: Floats) -> tuple[Floats, Floats]:
    """Return the share of friction that acts against forward motion, 0 to 1, and the speed (never 0), each (n,).

    Where the velocity is within ``sure`` (n,), :attr:`~mjfriction.record.motion.Motion.sure_speed`, the joint may be
    stuck.  A joint that passes through this range without pause reverses somewhere within it, so the share is
    interpolated linearly in time between its values before and after.  A joint that rests may hold any friction within
    its level in either direction; the best guess is none (a share of ½).  The same holds before the first and after
    the last motion.
    """
    speed = np.maximum(np.abs(velocity), sure / SURE)
    known = np.flatnonzero(np.abs(velocity) > sure)
    if not known.size:
        return np.full(velocity.size, 0.5), speed
    sample = np.arange(velocity.size)
    ahead = (velocity[known] > 0.0).astype(np.float64)
    forward = np.interp(sample, known, ahead, left=0.5, right=0.5)
    # A sample stands for the interval halfway to its neighbours.  A joint that reverses between two adjacent samples
    # does so instantly at the interpolated zero crossing; the sample whose interval contains that gets a share between.
    turned = known[:-1][(np.diff(known) == 1) & (np.diff(ahead) != 0.0)]
    at = velocity[turned] / (velocity[turned] - velocity[turned + 1]) - 0.5
    forward[turned] += np.sign(velocity[turned + 1]) * np.maximum(0.0, -at)
    forward[turned + 1] -= np.sign(velocity[turned + 1]) * np.maximum(0.0, at)
    gaps = np.flatnonzero(np.diff(known) > 1)
    if gaps.size:
        spans = np.column_stack([known[gaps] + 1, known[gaps + 1]])
        for first, past in spans[_rests(velocity, sure, spans)]:
            forward[first:past] = 0.5
    return forward, speed


def _rests(velocity: Floats, sure: Floats, spans: NDArray[np.intp]) -> NDArray[np.bool_]:
    # Whether a joint rests within each of some spans (first sample, and the one past the last).  A joint that reverses
    # at constant acceleration strays by a quarter of Σ sure, and one that passes through strays by more.  A joint that
    # strays by less than half of that quarter rests.
    travelled, ends = np.cumsum(velocity), spans.ravel()
    strayed = (np.maximum.reduceat(travelled, ends) - np.minimum.reduceat(travelled, ends))[::2]
    return np.asarray(strayed < RESTING * 0.25 * np.add.reduceat(sure, ends)[::2])
