"""Motions that exercise a machine: excitation, constant speeds, sines, sawtooth, loops, voltages, pick and place."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np

from mjfriction.errors import LogError
from mjfriction.laws.law import Floats
from mjfriction.plant.cylinder import speed_per_volt
from mjfriction.plant.trajectory import Trajectory
from mjfriction.record.log import VOLTAGE
from mjfriction.robot.schema import Hydraulics

FADE = 2.0  # s over which an excitation fades in from rest and fades out
KNOTS = 250.0  # Hz; sampling rate of the trajectory tables
STROKE_USED = 0.8  # fraction of a cylinder's stroke that each voltage covers at no-load speed; friction reduces it
# To bring a piston back to its end: voltage as a fraction of the limit, and no-load travel as a fraction of the stroke.
HOMING, HOME_AGAIN = 0.2, 1.5
VALVE_REST = 0.5  # s between two voltages


def excitation(
    joints: Sequence[str],
    centre: Floats,
    reach: Floats,
    top_speed: Floats,
    seconds: float,
    *,
    seed: int = 0,
    lines: int = 5,
    band: tuple[float, float] = (0.05, 0.5),
) -> Trajectory:
    """Return a sum of sines per joint about ``centre``, within ± ``reach`` (rad) and ``top_speed`` (rad/s).

    Frequencies are drawn from ``band`` (Hz), evenly in logarithm; all joints begin and end at rest at the centre.
    """
    rng = np.random.default_rng([seed, 21])
    time = np.arange(0.0, seconds + 0.5 / KNOTS, 1.0 / KNOTS)
    swell = _smooth(time / FADE) * _smooth((seconds - time) / FADE)
    position = np.empty((time.size, len(joints)))
    for i in range(len(joints)):
        frequency = np.exp(rng.uniform(np.log(band[0]), np.log(band[1]), lines))
        amplitude = rng.uniform(0.3, 1.0, lines) / (0.2 + frequency)
        course = swell * np.sum(
            amplitude * np.sin(2.0 * np.pi * (np.outer(time, frequency) + rng.uniform(0.0, 1.0, lines))), axis=1
        )
        speed = np.max(np.abs(np.gradient(course, time)))
        position[:, i] = centre[i] + course * min(reach[i] / np.max(np.abs(course)), top_speed[i] / speed)
    return Trajectory(tuple(joints), time, position)


def forward_backward(
    joint: str, start: float, stroke: float, speeds: Sequence[float], acceleration: float, *, dwell: float = 0.3
) -> Trajectory:
    """Return passes of one joint back and forth, one pair per speed, with trapezoidal velocity.

    Raises :class:`LogError` for a speed at which the stroke leaves no phase of constant speed: v²/a ≥ stroke.
    """
    parts = [np.full(_samples(dwell), start)]
    for speed in speeds:
        if speed * speed / acceleration >= stroke:
            raise LogError(
                f"joint '{joint}': at {speed:.4g} the trapezoid degenerates over a stroke of {stroke:.4g} with "
                f"{acceleration:.4g} of acceleration: no phase of constant speed is left; lower the speed below "
                f"{np.sqrt(stroke * acceleration):.4g} or raise the acceleration"
            )
        out = trapezoid(stroke, speed, acceleration)
        rest = np.full(_samples(dwell), start)
        parts += [start + out, rest + stroke, start + stroke - out, rest]
    return _at_knots((joint,), np.concatenate(parts)[:, None])


def trapezoid(stroke: float, speed: float, acceleration: float) -> Floats:
    """Return positions (n,) of a move over a stroke at 250 Hz, up to a speed (triangular where it is not reached)."""
    speed = min(speed, np.sqrt(stroke * acceleration))
    ramp, total = speed / acceleration, stroke / speed + speed / acceleration
    t = np.linspace(0.0, total, _samples(total) + 1)[1:]
    up, down = 0.5 * acceleration * t**2, stroke - 0.5 * acceleration * (total - t) ** 2
    between = 0.5 * speed * ramp + speed * (t - ramp)
    return np.where(t <= ramp, up, np.where(t >= total - ramp, down, between))


def sine(joint: str, centre: float, amplitude: float, frequency: float, periods: float) -> Trajectory:
    """Return a sine of one joint that fades in and out over its first and last half period."""
    seconds = periods / frequency
    time = np.arange(0.0, seconds + 0.5 / KNOTS, 1.0 / KNOTS)
    half = 0.5 / frequency
    swell = _smooth(time / half) * _smooth((seconds - time) / half)
    return Trajectory((joint,), time, (centre + amplitude * swell * np.sin(2.0 * np.pi * frequency * time))[:, None])


def sawtooth(joint: str, centre: float, amplitudes: Sequence[float], speed: float) -> Trajectory:
    """Return slow constant-speed motion between ± each amplitude in turn, which traces hysteresis loops."""
    corners = np.concatenate([[0.0], *([a, -a] for a in amplitudes), [0.0]])
    time = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(corners)) / speed)])
    return _even((joint,), time, centre + corners[:, None])


def inner_loops(joint: str, centre: float, amplitude: float, period: float, *, periods: int = 2) -> Trajectory:
    """Return a motion between ± an amplitude that turns back once each way: two inner hysteresis loops a period.

    It goes up to 0.6 of the amplitude, back to −0.1 and up to the whole; then the same downward.  Every stretch is
    smooth and takes a part of the period in proportion to its length.  Before the first period the joint goes to
    −amplitude.
    """
    turns = amplitude * np.array([0.0, -1.0, *([0.6, -0.1, 1.0, -0.6, 0.1, -1.0] * periods)])
    around = float(np.sum(np.abs(np.diff(turns[1:8]))))
    parts = [np.full(1, centre)]
    for a, b in itertools.pairwise(turns):
        share = np.linspace(0.0, 1.0, _samples(period * abs(b - a) / around) + 1)[1:]
        parts.append(centre + a + (b - a) * _smooth(share))
    return _at_knots((joint,), np.concatenate(parts)[:, None])


def valve_steps(joint: str, of: Hydraulics, stroke: float, volts: Sequence[float]) -> Trajectory:
    """Return constant voltages at the valve of a cylinder, out and back at each, over about half of a stroke (m).

    The piston begins at zero, in the middle.  Friction slows it more going back than out.  So before each pair it is
    driven back against its end, at the voltage nearest to :data:`HOMING`, and every pair begins at the same place.
    """
    out, back = speed_per_volt(of)
    way, gentle = STROKE_USED * stroke, min(volts, key=lambda volt: abs(volt - HOMING * of.voltage_limit))
    steps = []
    for voltage in volts:
        steps += [(-gentle, HOME_AGAIN * stroke / (back * gentle)), (voltage, way / (out * voltage))]
        steps += [(-voltage, way / (out * voltage))]
    rest = np.zeros(_samples(VALVE_REST))
    course = np.concatenate([rest] + [np.append(np.full(_samples(time), volt), rest) for volt, time in steps])
    time = np.arange(course.size) / KNOTS
    return Trajectory((), time, np.empty((course.size, 0)), {f"{VOLTAGE}.{joint}": course})


def pick_and_place(
    joints: Sequence[str],
    poses: Floats,
    top_speed: Floats,
    acceleration: Floats,
    *,
    rounds: int = 3,
    dwell: float = 0.4,
) -> Trajectory:
    """Return moves of all joints together from pose to pose (poses, joints), ``rounds`` times, resting at each.

    Joints move synchronously: each move takes as long as its slowest joint needs.
    """
    poses = np.asarray(poses)
    order = [*range(len(poses))] * rounds + [0]
    parts = [np.tile(poses[0], (_samples(dwell), 1))]
    for a, b in itertools.pairwise(order):
        parts += [move(poses[a], poses[b], top_speed, acceleration), np.tile(poses[b], (_samples(dwell), 1))]
    return _at_knots(tuple(joints), np.concatenate(parts))


def move(start: Floats, end: Floats, top_speed: Floats, acceleration: Floats) -> Floats:
    """Return the positions (n, joints) of a smooth, synchronous move at 250 Hz, no joint beyond its limits."""
    way = end - start
    # The blend s³(10 − 15 s + 6 s²) has a peak speed of 1.875 and a peak acceleration of 5.774, over unit time.
    by_speed = float(np.max(1.875 * np.abs(way) / top_speed))
    seconds = max(by_speed, float(np.max(np.sqrt(5.774 * np.abs(way) / acceleration))))
    s = np.linspace(0.0, 1.0, _samples(seconds) + 1)[1:]
    return np.asarray(start + np.outer(_smooth(s), way))


def _samples(seconds: float) -> int:
    return max(1, int(np.ceil(seconds * KNOTS - 1e-9)))


def _at_knots(joints: tuple[str, ...], position: Floats) -> Trajectory:
    return Trajectory(joints, np.arange(position.shape[0]) / KNOTS, position)


def _even(joints: tuple[str, ...], time: Floats, position: Floats) -> Trajectory:
    grid = np.arange(0.0, time[-1] + 0.5 / KNOTS, 1.0 / KNOTS)
    return Trajectory(joints, grid, np.column_stack([np.interp(grid, time, column) for column in position.T]))


def _smooth(share: Floats) -> Floats:
    s = np.clip(share, 0.0, 1.0)
    return np.asarray(s**3 * (10.0 - 15.0 * s + 6.0 * s**2))
