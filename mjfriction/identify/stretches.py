"""Stretches of a log simulated freely: the efforts that the drives reported are played in, and where the joints go is
compared with where they went.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mjfriction.errors import RobotError
from mjfriction.identify.gap import Gap
from mjfriction.record.log import HELD_MASS, Floats, Integers
from mjfriction.robot.links_torque import held_mass
from mjfriction.robot.robot import Robot
from mjfriction.robot.simulation import not_in_model, robot_laws, robot_spec
from mjfriction.sim.attach import attach
from mjfriction.sim.replay import replay

LONGEST_STEP = 1e-3  # s
COMPARED_EVERY = 0.01  # s between the positions that are compared
SHORTEST = 0.05  # s
ENOUGH = 60  # stretches; short logs give as many by overlapping, for where a swing is cut says much of where it ends
MOST_OVERLAP = 0.75
LOST = 1e3  # rad or m
IN_MODEL_TOO = frozenset(
    {"effort_sensor", "position_sensor"}
)  # keys whose scale, offset and delay the log is cleared of


@dataclass(frozen=True)
class Stretches:
    """Stretches of a log on the models' clock: where they begin (k, joints), the efforts reported (k, steps, joints),
    and the positions ``measured`` (k, m, joints) at the steps ``compared`` (m,).
    """

    position: Floats
    velocity: Floats
    reported: Floats
    measured: Floats
    compared: Integers
    step: float

    @property
    def seconds(self) -> float:
        """How long each is, s."""
        return float(self.reported.shape[1] * self.step)


def simulated_error(gap: Gap, robot: Robot, seconds: float) -> tuple[Floats, float]:
    """Return how far a robot's joints end up from where they were, RMS over stretches of so many seconds in which the
    log's efforts drive it freely, (joints,) rad or m; and how long the stretches came to be, s.

    Raises what :func:`cut_stretches` raises.
    """
    fixed = cut_stretches(gap, robot, seconds)
    return rms(missed(gap, [robot], fixed)[0]), fixed.seconds


def cut_stretches(gap: Gap, robot: Robot, seconds: float) -> Stretches:
    """Cut a gap's log into stretches of so many seconds, or of its longest piece where ``seconds`` is infinite.

    Stretches of a short log overlap; pieces shorter than one are left out.  ``robot`` says what its sensors add.

    Raises :class:`RobotError` where a joint has no effort, the robot holds parts that its MuJoCo model does not, or
    ``seconds`` is no time to compare.
    """
    if not seconds >= SHORTEST:
        raise RobotError(f"{seconds} s are no stretch to simulate; give {SHORTEST} s or more, or inf for the whole log")
    motion = gap.motion
    if held_mass(robot, motion) is not None:
        raise RobotError(
            f"{gap.log.source}: its '{HELD_MASS}' is not in the MuJoCo model, so that simulated motion cannot be "
            "compared; take logs of one mass by themselves, and state it as the robot's payload"
        )
    if robot.table.taken_up:
        raise RobotError(
            f"robot '{robot.name}': what it takes up is not in the MuJoCo model, so that simulated motion cannot be "
            "compared; take a log of one mass, and state it as the robot's payload"
        )
    lacking = [joint for i, joint in enumerate(robot.joints) if i not in gap.examined]
    if lacking:
        raise RobotError(f"simulated motion needs the efforts of all joints, and {', '.join(lacking)} has none")
    for joint in robot.table.joint:
        beyond = [key for key in not_in_model(joint) if key not in IN_MODEL_TOO]
        if beyond:
            raise RobotError(
                f"joint '{joint.name}': its {', '.join(beyond)} is not in the MuJoCo model, so that simulated motion "
                "cannot be compared; do without it"
            )
    fine = max(1, int(np.ceil(1.0 / (motion.rate * LONGEST_STEP) - 1e-9)))
    step = 1.0 / (motion.rate * fine)
    zero = np.array([joint.position_sensor.offset for joint in robot.table.joint])
    bounds = np.flatnonzero(np.diff(motion.piece)) + 1
    pieces = list(itertools.pairwise([0, *bounds.tolist(), motion.time.size]))
    longest = max(past - first for first, past in pieces)
    length = round(min(seconds * motion.rate, longest - 1))
    whole = sum((past - first) // length for first, past in pieces)
    apart = max(1, round(length * float(np.clip(whole / ENOUGH, 1.0 - MOST_OVERLAP, 1.0))))
    cuts = [(first, s, past) for first, past in pieces for s in range(first, past - length + 1, apart)]
    starts = [s for _, s, _ in cuts]
    compared = np.arange(0, length * fine, max(1, round(COMPARED_EVERY / step)))[1:]
    clock = np.arange(length * fine) / fine
    # An effort is held over its step, so that the middle's is taken; a drive that reports late is read ahead.
    delay = np.array([joint.effort_sensor.delay for joint in robot.table.joint])
    middle, late = clock + 0.5 / fine, delay * motion.rate

    def on_steps(values: Floats, at: Floats, ahead: Floats) -> Floats:
        shifted = list(zip(range(ahead.size), ahead, strict=True))
        # What a late drive reports of a stretch's end comes after it, as far as the piece goes.
        return np.stack(
            [
                np.column_stack(
                    [np.interp(s + at + shift, np.arange(first, past), values[first:past, k]) for k, shift in shifted]
                )
                for first, s, past in cuts
            ]
        )

    position = motion.position - zero
    return Stretches(
        position=position[starts],
        velocity=motion.velocity[starts],
        reported=on_steps(motion.torque * gap.per_reported, middle, late),
        measured=on_steps(position, clock, np.zeros(delay.size))[:, compared],
        compared=compared,
        step=step,
    )


def missed(gap: Gap, robots: Sequence[Robot], stretches: Stretches) -> Floats:
    """Return where each robot's simulation ends up, less where the machine was, (robots, stretches, compared, joints).

    The efforts reported are each robot's own sensors' to read; what flew away is a thousand rad or m off.
    """
    models, efforts = [], []
    for robot in robots:
        spec = robot_spec(robot)
        spec.option.timestep = stretches.step
        models.append(attach(spec, robot_laws(robot)))
        efforts.append((stretches.reported - _offset(robot)) / _scale(robot))
    went = replay(models, gap.robot.joints, stretches.position, stretches.velocity, np.array(efforts))
    return np.nan_to_num(went[:, :, stretches.compared] - stretches.measured, nan=LOST, posinf=LOST, neginf=-LOST)


def _scale(robot: Robot) -> Floats:
    return np.array([joint.effort_sensor.scale for joint in robot.table.joint])


def _offset(robot: Robot) -> Floats:
    return np.array([joint.effort_sensor.offset for joint in robot.table.joint])


def rms(missed: Floats) -> Floats:
    """Return the RMS (joints,) of what was missed, (stretches, compared, joints)."""
    return np.asarray(np.sqrt(np.mean(np.square(missed), axis=(0, 1))))
