"""The motion that would tell two explanations apart: where the two fitted robots differ most, over the noise."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mjfriction.diagnose.causes.catalog import STATED_LEVELS
from mjfriction.diagnose.extend import extend_robot
from mjfriction.diagnose.model import Chosen, Model, build_model
from mjfriction.identify.gap import Gap
from mjfriction.identify.protocol import candidate_motions, difference, motion_along, unbounded
from mjfriction.plant.trajectory import Trajectory
from mjfriction.record.log import Floats
from mjfriction.robot.robot import Robot

TOLD = 3.0  # times the noise, from which on two explanations are told apart
USELESS = 0.05  # times the noise: a thousand rows that differ so much may do so by chance
QUIETEST = 1e-9  # N·m or N
FASTER = 1.5  # times the speed that the log reached


@dataclass(frozen=True)
class Experiment:
    """A motion, and how far the two explanations lie apart on it and on the log, in units of the noise."""

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
    """Return a model with a rival in the place of a cause; None where, beside what else was found, it is not
    possible.

    In the place of a joint's levels, these are as stated; levels in the place of a cause are free, rather than as
    stated or near it.
    """
    rest = tuple(choice for choice in model.chosen if choice.key != target.key)
    if rival.cause is STATED_LEVELS and model.nuisance.level_near(rival.site.joint):
        return build_model(model.gap, model.nuisance.with_level_free(rival.site.joint), rest).admissible()
    held = target.cause is STATED_LEVELS
    nuisance = model.nuisance.without_level(target.site.joint) if held else model.nuisance
    other = build_model(model.gap, nuisance, (*rest, rival)).admissible()
    return other if rival.key in [choice.key for choice in other.chosen] else None


def design_experiment(model: Model, other: Model, joint: int, between: tuple[str, str]) -> Experiment | None:
    """Return the motion, of many within the joints' limits, on which two explanations of a log, ``between`` whose
    causes at a ``joint`` it is to choose, differ most.

    Both are fitted to the log.  Where motions in the middle of the range tell nothing, that joint is moved alone to its
    sides.  None where they differ nowhere by more than on the log itself, or by so little that some minutes of it would
    say nothing; and none for a robot with a slide of which no range is stated.
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
    # Of each examined joint's samples: the sensor's, or what is left, where a drive has taken the noise away.
    gap, left = model.gap, model.residual()
    rows = [max(float(gap.noise_floor[joint]), gap.rms(left[:, joint], joint)) for joint in gap.examined]
    return np.maximum(np.array(rows) / gap.chain.noise_gain, QUIETEST)


def _apart(gap: Gap, robots: list[Robot], noise: Floats, trajectory: Trajectory | None) -> tuple[float, int]:
    motion = gap.motion if trajectory is None else motion_along(gap.robot, trajectory)
    size = difference(robots, motion)[list(gap.examined)]
    worst = int(np.argmax(size / noise))
    return float((size / noise)[worst]), gap.examined[worst]
