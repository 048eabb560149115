"""Free simulation of stretches of a log.

The efforts that the drives reported are applied to the model, and where its joints go is compared with where the
machine's went.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mjfriction.errors import RobotError
from mjfriction.identify.gap import Gap
from mjfriction.record.log import Floats, Integers
from mjfriction.record.motion import Motion
from mjfriction.robot.model_drive import drive_model
from mjfriction.robot.robot import Robot
from mjfriction.robot.simulation import robot_laws, robot_spec
from mjfriction.sim.attach import attach
from mjfriction.sim.replay import replay
from mjfriction.sim.spec import compiled, drop_actuators

LONGEST_STEP = 1e-3  # s
COMPARED_EVERY = 0.01  # s between the positions that are compared
SHORTEST = 0.05  # s
# Stretches; short logs give as many by overlapping, because where a swing is cut largely decides where it ends.
ENOUGH = 60
MOST_OVERLAP = 0.75
LOST = 1e3  # rad or m, the error of a simulation that diverged
BEFORE = 0.4  # s of motion on both sides of a stretch on which what is known along it is computed
UNMOVED = 1e9  # kg·m² or kg, an armature so heavy that a joint that is held stays where it began


@dataclass(frozen=True)
class Cuts:
    """Where stretches of a motion lie: the samples at which they begin, (k,).

    Each spans ``length`` samples and one more, within one piece.
    """

    begins: Integers
    length: int

    def some(self, own: Integers) -> Cuts:
        """Return the stretches with the given numbers."""
        return Cuts(self.begins[own], self.length)


@dataclass(frozen=True)
class Stretches:
    """Stretches of a log at the simulation's time steps.

    They are: where they begin, ``position`` and ``velocity`` (k, joints); the efforts ``reported`` (k, steps, joints);
    and the positions ``measured`` (k, m, joints) at the steps ``compared`` (m,).  The efforts are those that drives
    without filter or delay would report, less what a robot states beside its MuJoCo model.  Joints that are ``held``
    stay where they began.
    """

    position: Floats
    velocity: Floats
    reported: Floats
    measured: Floats
    compared: Integers
    step: float
    held: tuple[str, ...]

    @property
    def seconds(self) -> float:
        """Duration of each stretch, s."""
        return float(self.reported.shape[1] * self.step)


def simulated_error(gap: Gap, robot: Robot, seconds: float) -> tuple[Floats, float]:
    """Return how far a robot's joints end up from where they were, (joints,) rad or m, and the stretches' duration, s.

    The error is an RMS over stretches of about ``seconds``, in which the log's efforts drive the robot freely.

    Raises what :func:`cut_stretches` raises.
    """
    fixed = cut_stretches(gap, robot, seconds)
    return rms(missed(gap, [robot], fixed)[0]), fixed.seconds


def cut_stretches(gap: Gap, robot: Robot, seconds: float) -> Stretches:
    """Cut a gap's log into stretches of so many seconds, or of its longest piece where ``seconds`` is infinite.

    Stretches of a short log overlap; pieces shorter than one are left out.  ``robot`` says what its sensors add and
    what acts beside its MuJoCo model.

    Raises :class:`RobotError` where a joint that moves has no effort, or ``seconds`` is too short to compare.
    """
    if not seconds >= SHORTEST:
        raise RobotError(f"{seconds} s are no stretch to simulate; give {SHORTEST} s or more, or inf for the whole log")
    motion = gap.motion
    pieces = [(own.start, own.stop) for own in motion.pieces]
    longest = max(past - first for first, past in pieces)
    length = max(1, round(min(seconds * motion.rate, longest - 1)))
    whole = sum((past - first) // length for first, past in pieces)
    apart = max(1, round(length * float(np.clip(whole / ENOUGH, 1.0 - MOST_OVERLAP, 1.0))))
    begins = [begin for first, past in pieces for begin in range(first, past - length, apart)]
    return stretches_at(gap, robot, Cuts(np.array(begins), length))


def stretches_at(gap: Gap, robot: Robot, cuts: Cuts) -> Stretches:
    """Return the stretches of a gap's log at ``cuts``, driven as a robot says that its MuJoCo model is driven.

    Raises :class:`RobotError` where a joint that moves has no effort.
    """
    held = [i for i in range(len(robot.joints)) if i not in gap.examined]
    turning = gap.motion.moving & ~gap.motion.dawdling
    lacking = [robot.joints[i] for i in held if turning[i]]
    if lacking:
        raise RobotError(f"simulated motion needs the efforts of all joints, and {', '.join(lacking)} has none")
    motion, begins = _around(gap.motion, cuts)
    fine = max(1, int(np.ceil(1.0 / (motion.rate * LONGEST_STEP) - 1e-9)))
    step = 1.0 / (motion.rate * fine)
    compared = np.arange(0, cuts.length * fine, max(1, round(COMPARED_EVERY / step)))[1:]
    clock = np.arange(cuts.length * fine) / fine
    driven = drive_model(robot, motion)
    torque = driven.torque.copy()
    torque[:, held] = 0.0
    velocity = driven.velocity[begins]
    velocity[:, held] = 0.0
    return Stretches(
        position=driven.position[begins],
        velocity=velocity,
        # An effort is held over its step, so take its value at mid-step.
        reported=_on_steps(torque, begins, clock + 0.5 / fine) * _scale(robot) + _offset(robot),
        measured=_on_steps(driven.position, begins, clock[compared]),
        compared=compared,
        step=step,
        held=tuple(robot.joints[i] for i in held),
    )


def _around(motion: Motion, cuts: Cuts) -> tuple[Motion, Integers]:
    # The motion of the stretches and a margin around them, within their pieces; and the samples where they begin.
    margin = int(np.ceil(BEFORE * motion.rate))
    wanted = np.zeros(motion.time.size, dtype=bool)
    for begin in cuts.begins.tolist():
        near = slice(max(begin - margin, 0), begin + cuts.length + 1 + margin)
        wanted[near] |= motion.piece[near] == motion.piece[begin]
    kept = np.flatnonzero(wanted)
    return motion.stretches(kept), np.searchsorted(kept, cuts.begins)


def _on_steps(values: Floats, begins: Integers, at: Floats) -> Floats:
    # Interpolate values (n, joints) at times (m,), in samples since the stretches begin, (k, m, joints).
    whole = at.astype(np.int64)
    share = (at - whole)[:, None]
    first = begins[:, None] + whole
    return np.asarray((1.0 - share) * values[first] + share * values[first + 1])


def missed(gap: Gap, robots: Sequence[Robot], stretches: Stretches) -> Floats:
    """Return where each robot's simulation goes, less where the machine went, (robots, stretches, compared, joints).

    Each robot reads the reported efforts through its own sensors, and its model's own actuators are left out.  A
    simulation that diverges is a thousand rad or m off.
    """
    models, efforts = [], []
    for robot in robots:
        spec = robot_spec(robot)
        drop_actuators(spec)
        spec.option.timestep = stretches.step
        for name in stretches.held:
            spec.joint(name).armature = UNMOVED
        laws = robot_laws(robot)
        models.append(attach(spec, laws) if laws else compiled(spec))
        efforts.append((stretches.reported - _offset(robot)) / _scale(robot))
    went = replay(models, gap.robot.joints, stretches.position, stretches.velocity, np.array(efforts))
    off = np.nan_to_num(went[:, :, stretches.compared] - stretches.measured, nan=LOST, posinf=LOST, neginf=-LOST)
    return np.clip(off, -LOST, LOST)


def _scale(robot: Robot) -> Floats:
    return np.array([joint.effort_sensor.scale for joint in robot.table.joint])


def _offset(robot: Robot) -> Floats:
    return np.array([joint.effort_sensor.offset for joint in robot.table.joint])


def rms(missed: Floats) -> Floats:
    """Return the RMS (joints,) of the errors (stretches, compared, joints) that :func:`missed` gives."""
    return np.asarray(np.sqrt(np.mean(np.square(missed), axis=(0, 1))))
