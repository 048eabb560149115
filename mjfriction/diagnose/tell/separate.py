"""The motion that would tell two explanations apart: the fitted robots differ most on it, relative to the noise."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mjfriction.diagnose.causes.catalog import STATED_LEVELS
from mjfriction.diagnose.fit.extend import extend_robot
from mjfriction.diagnose.fit.model import Chosen, Model, build_model
from mjfriction.identify.gap import Gap
from mjfriction.identify.protocol import candidate_motions, difference, motion_along, unbounded
from mjfriction.plant.trajectory import Trajectory
from mjfriction.record.log import Floats
from mjfriction.robot.robot import Robot

TOLD = 3.0  # multiple of the noise; two explanations that differ by more are told apart
USELESS = 0.05  # multiple of the noise; a smaller difference over a thousand rows may be chance
QUIETEST = 1e-9  # N·m or N, lower limit of the noise
FASTER = 1.5  # top speed of the trial motions, as a multiple of the speed that the log reached


@dataclass(frozen=True)
class Experiment:
    """A motion, and by how much the two explanations differ on it and on the log, as multiples of the noise."""

    trajectory: Trajectory
    joint: str
    apart: float
    apart_on_log: float
    between: tuple[str, str]

    @property
    def words(self) -> str:
        """What to do and why, in a sentence."""
        one, other = self.between
        return (
            f"run the motion in next_experiment.parquet ({self.trajectory.time[-1]:.0f} s): there {one} and {other} "
            f"differ by {self.apart:.2g} times the noise at {self.joint}, on this log by {self.apart_on_log:.2g}"
        )


def with_rival(model: Model, target: Chosen, rival: Chosen) -> Model | None:
    """Return the model with a rival in place of a cause, or None if the rival is not admissible beside the other
    causes.

    If the rival replaces a joint's levels, these are held as stated.  If levels replace a cause, they are free, rather
    than held as stated or near it.
    """
    rest = tuple(choice for choice in model.chosen if choice.key != target.key)
    if rival.cause is STATED_LEVELS and model.nuisance.level_near(rival.site.joint):
        return build_model(model.gap, model.nuisance.with_level_free(rival.site.joint), rest).admissible()
    held = target.cause is STATED_LEVELS
    nuisance = model.nuisance.without_level(target.site.joint) if held else model.nuisance
    other = build_model(model.gap, nuisance, (*rest, rival)).admissible()
    return other if rival.key in [choice.key for choice in other.chosen] else None


def design_experiment(model: Model, other: Model, joint: int, between: tuple[str, str]) -> Experiment | None:
    """Return the motion, out of many within the joints' limits, on which two explanations of a log differ most.

    Both models are fitted to the log; ``between`` names the two causes at ``joint`` that the motion is to tell apart.
    If motions in the middle of the range do not tell them apart, this joint alone is moved towards the sides of its
    range.  Return None if they differ on no motion by more than on the log itself, or by so little that a few minutes
    of it would decide nothing, or if the robot has a sliding joint without a stated range.
    """
    gap = model.gap
    if unbounded(gap.body):
        return None
    robots = [extend_robot(model), extend_robot(other)]
    noise = _noise(model)
    on_log, _ = _apart(gap, robots, noise, None)
    best: Experiment | None = None
    top = FASTER * np.max(np.abs(gap.motion.velocity), axis=0)
    for side in (0.0, -1.0, 1.0):
        motions = candidate_motions(gap.robot.joints, gap.body, top, joint, all_joints=side == 0.0, side=side)
        for trajectory in motions:
            apart, shown = _apart(gap, robots, noise, trajectory)
            if apart > on_log and (best is None or apart > best.apart):
                best = Experiment(trajectory, gap.robot.joints[shown], apart, on_log, between)
        if side == 0.0 and best is not None and best.apart > TOLD:
            break
    return best if best is not None and best.apart > USELESS else None


def _noise(model: Model) -> Floats:
    # The noise of each examined joint's samples: the sensor's, or the residual if that is larger, since a drive may
    # have filtered the sensor's noise away.
    gap, left = model.gap, model.residual()
    rows = [max(float(gap.noise_floor[joint]), gap.rms(left[:, joint], joint)) for joint in gap.examined]
    return np.maximum(np.array(rows) / gap.chain.noise_gain, QUIETEST)


def _apart(gap: Gap, robots: list[Robot], noise: Floats, trajectory: Trajectory | None) -> tuple[float, int]:
    motion = gap.motion if trajectory is None else motion_along(gap.robot, trajectory)
    size = difference(robots, motion)[list(gap.examined)]
    worst = int(np.argmax(size / noise))
    return float((size / noise)[worst]), gap.examined[worst]
