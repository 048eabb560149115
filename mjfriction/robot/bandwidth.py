"""How much of a log's frequency range is usable."""

from __future__ import annotations

import numpy as np

from mjfriction.body.inverse import inertia_at
from mjfriction.body.model import Body
from mjfriction.errors import LogError
from mjfriction.record.log import POSITION, VELOCITY, Log
from mjfriction.record.motion_frequency import quickest_motion
from mjfriction.record.noise import raw_noise
from mjfriction.record.recorded_velocity import velocity_lateness
from mjfriction.record.resample import read_clock
from mjfriction.robot.effort import effort_per_reported
from mjfriction.robot.robot import Robot

HIGHEST = 100.0  # Hz; above it, rigid bodies and friction explain nothing of what a manipulator does
HARMONICS = 5.0  # the cutoff is at least this many times the highest frequency of the motion itself
NOISE_SHARE = 0.5  # largest inertia torque from position noise, as a fraction of the effort's own noise
EFFORT_SHARE = 0.01  # inertia torque from position noise that is always accepted, as a fraction of the effort's std


def choose_cutoff(log: Log, robot: Robot, body: Body, highest: float = HIGHEST) -> float:
    """Return the cutoff (Hz) for the position filter of a log.

    After a low-pass of cutoff f and two differentiations, white position noise σ_q appears as an inertia torque of
    standard deviation J·σ_q·(2πf)²·√(2f/5r) at sampling rate r; white effort noise appears as σ_τ·√(2f/r). The cutoff
    is the highest f at which, on every joint, the first stays below half of the second or below 1 % of the effort's
    standard deviation, whichever is larger. A measured velocity that agrees with the position and is not merely derived
    from it needs one differentiation less and is used where it is quieter. The cutoff is at most ``highest`` (Hz) and
    at most a fifth of the rate, and within that at least five times the highest frequency of the motion itself.

    Raises :class:`LogError` when no joint of the log moves.
    """
    clock = read_clock(log)
    rate = 1.0 / clock.step
    highest = min(highest, rate / 5.0)
    positions = {joint: log.channel(POSITION, joint) for joint in robot.joints}
    pose = np.array([np.mean(values) for values in positions.values() if values is not None])
    inertia = inertia_at(body, pose)
    known = [
        (values, slides) for values, slides in zip(positions.values(), body.sliding, strict=True) if values is not None
    ]
    courses, sliding = zip(*known, strict=True)
    pieces = [slice(*piece) for piece in clock.pieces]
    cutoff, motion = highest, quickest_motion(np.column_stack(courses), pieces, rate, sliding)
    for i, joint in enumerate(robot.table.joint):
        values = positions[joint.name]
        if values is None or np.ptp(values) == 0.0:
            continue
        quantity = log.torque_quantity(joint.name)
        reported = log.channel(quantity, joint.name) if quantity else None
        if quantity is None or reported is None:
            continue
        per_reported = abs(effort_per_reported(joint, quantity, robot.name))
        position_noise = raw_noise(log, POSITION, joint.name, clock)
        recorded = velocity_lateness(log, joint.name, highest, clock) is not None
        velocity_noise = raw_noise(log, VELOCITY, joint.name, clock) if recorded else None
        effort_noise = per_reported * raw_noise(log, quantity, joint.name, clock)
        level = per_reported * float(np.std(reported)) * EFFORT_SHARE
        frequency = np.linspace(1.0, highest, 200)
        band = np.sqrt(2.0 * frequency / rate)
        angular = 2.0 * np.pi * frequency
        jitter = position_noise * np.square(angular) * band / np.sqrt(5.0)
        if velocity_noise is not None:
            jitter = np.minimum(jitter, velocity_noise * angular * band / np.sqrt(3.0))
        inertial = inertia[i] * jitter
        quiet = inertial <= np.maximum(NOISE_SHARE * effort_noise * band, level)
        cutoff = min(cutoff, float(frequency[quiet][-1]) if np.any(quiet) else 1.0)
    if motion == 0.0:
        raise LogError(
            f"{log.source}: no joint moves: every position is constant; friction shows only in motion, "
            "record the joints moving in both directions"
        )
    return min(highest, max(cutoff, HARMONICS * motion))
