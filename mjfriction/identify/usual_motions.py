"""Other motions of the laboratory, sized to a robot: slow sines, sawtooth, loops, pick and place, voltages."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from mjfriction.errors import RobotError
from mjfriction.identify.protocol import UNSTATED_SPEED, Plan, joined, room
from mjfriction.plant.motions import inner_loops, pick_and_place, sawtooth, sine, valve_steps
from mjfriction.plant.trajectory import Trajectory
from mjfriction.robot.robot import Robot

SLOW = 0.05  # share of the top speed that a slow sine reaches
SLOW_FREQUENCY, SLOW_PERIODS = 0.1, 3.0  # Hz, and number of periods
# Usual amplitude as a share of a joint's reach: turns of a few hundredths of a degree, or some hundredths of a
# millimetre.
SMALL = 1e-3
LADDER = (1.0, 0.6, 0.3)  # amplitudes of a sawtooth, as shares of the largest
SAW_SECONDS = 4.0  # s from the middle to the largest turn
LOOP_SECONDS, LOOP_WAY = 10.0, 7.0  # s, the period of loops; and its path in amplitudes, nearly
POSES = 4  # poses of pick and place
RAMP = 2.0  # 1/s: top speeds are reached in half a second
VOLTAGES = 8


def plan_sine(robot: Robot, joints: Sequence[str]) -> Plan:
    """Plan slow sines of one joint after another, as used to test friction near rest."""
    top = np.minimum(robot.body().top_speed, UNSTATED_SPEED)

    def one(name: str, centre: float, reach: float) -> Trajectory:
        speed = SLOW * float(top[robot.joints.index(name)])
        amplitude = min(reach, speed / (2.0 * np.pi * SLOW_FREQUENCY))
        return sine(name, centre, amplitude, SLOW_FREQUENCY, SLOW_PERIODS)

    return _one_by_one(robot, joints, one, "slow sines")


def plan_sawtooth(robot: Robot, joints: Sequence[str], amplitude: float | None = None) -> Plan:
    """Plan slow turns of falling size (the largest ``amplitude``, rad or m), which draw hysteresis loops.

    Raises :class:`RobotError` for an amplitude beyond a joint's limits, as :func:`plan_loops` does.
    """

    def one(name: str, centre: float, reach: float) -> Trajectory:
        largest = _within(robot, name, amplitude, reach, 1.0 / SAW_SECONDS)
        return sawtooth(name, centre, [share * largest for share in LADDER], largest / SAW_SECONDS)

    return _one_by_one(robot, joints, one, "turns of falling size")


def plan_loops(robot: Robot, joints: Sequence[str], amplitude: float | None = None) -> Plan:
    """Plan motion between ± ``amplitude`` (rad or m) with two inner loops per period."""

    def one(name: str, centre: float, reach: float) -> Trajectory:
        # Each stretch takes its share of the period by its length, and peaks at 1.875 of its mean speed.
        largest = _within(robot, name, amplitude, reach, 1.875 * LOOP_WAY / LOOP_SECONDS)
        return inner_loops(name, centre, largest, LOOP_SECONDS)

    return _one_by_one(robot, joints, one, "two inner loops a period")


def plan_pick_and_place(robot: Robot, *, seed: int = 0) -> Plan:
    """Plan moves of all joints between poses drawn within limits, resting at each."""
    body = robot.body()
    middle, reach = room(body)
    top = np.minimum(body.top_speed, UNSTATED_SPEED)
    poses = middle + reach * np.random.default_rng([seed, 31]).uniform(-1.0, 1.0, (POSES, middle.size))
    made = pick_and_place(robot.joints, poses, top, RAMP * top)
    return Plan(made, (f"all joints from pose to pose, {POSES} poses three times round",))


def plan_voltages(robot: Robot, joints: Sequence[str]) -> Plan:
    """Plan constant voltages at the valve of a cylinder, out and back, rising from a thirtieth of the highest.

    Raises :class:`RobotError` where a cylinder moves none of the joints, or several.
    """
    valves = [name for name in joints if robot.joint(name).hydraulics is not None]
    if len(valves) != 1:
        found = f"these have one: {', '.join(valves)}; name one" if valves else "none of them has"
        raise RobotError(
            f"constant voltages are for the valve of one cylinder; of {', '.join(joints)} of '{robot.name}' {found}"
        )
    (name,) = valves
    of = robot.joint(name).hydraulics
    assert of is not None
    body = robot.body()
    index = robot.joints.index(name)
    stroke = float(body.upper[index] - body.lower[index])
    volts = np.geomspace(of.voltage_limit / 30.0, of.voltage_limit, VOLTAGES)
    made = valve_steps(name, of, min(stroke, 2.0), volts.tolist())
    return Plan(made, (f"{name}: {VOLTAGES} voltages from {volts[0]:.3g} to {volts[-1]:.3g} V, out and back",))


def _within(robot: Robot, joint: str, amplitude: float | None, reach: float, rate: float) -> float:
    # The amplitude requested, or the usual one; ``rate`` is the speed per amplitude.
    if amplitude is None:
        return SMALL * reach
    body = robot.body()
    top = min(float(body.top_speed[robot.joints.index(joint)]), UNSTATED_SPEED)
    largest = min(reach, top / rate)
    if amplitude > largest:
        raise RobotError(
            f"joint '{joint}': an amplitude of {amplitude:g} is past its limits; at most {largest:.4g} is allowed"
        )
    return amplitude


def _one_by_one(
    robot: Robot, joints: Sequence[str], make: Callable[[str, float, float], Trajectory], what: str
) -> Plan:
    body = robot.body()
    middle, reach = room(body)
    parts = []
    for name in joints:
        robot.joint(name)
        index = robot.joints.index(name)
        made = make(name, float(middle[index]), float(reach[index]))
        pose = np.tile(middle, (made.time.size, 1))
        pose[:, index] = made.position[:, 0]
        parts.append(pose)
    return Plan(joined(robot.joints, parts, body), (f"{what} of {', '.join(joints)}",))
