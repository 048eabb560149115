"""The motion that would tell two explanations apart: where the two fitted robots differ most, over the noise."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pyarrow as pa

from mjfriction.body.model import Body
from mjfriction.diagnose.extend import extend_robot
from mjfriction.diagnose.model import Chosen, Model, build_model
from mjfriction.identify.gap import Gap
from mjfriction.plant.motions import excitation, forward_backward
from mjfriction.plant.trajectory import Trajectory
from mjfriction.record.log import EFFORT, POSITION, Floats
from mjfriction.record.motion import estimate_motion
from mjfriction.record.readers.table import log_from_table
from mjfriction.robot.effort import predict_effort
from mjfriction.robot.robot import Robot

SECONDS = 40.0
SEEDS = 4
CUTOFF = 20.0  # Hz
LONGEST_PASS, PASSES = 20.0, 4  # s to and fro, and how many
REACH = 0.4  # of the way between a joint's limits, either side of the middle
WIDEST = 1.2  # rad or m of reach, where limits are wide
FASTER = 1.5  # times the speed that the log reached


@dataclass(frozen=True)
class Experiment:
    """A motion, and how far the two explanations lie apart on it and on the log, in units of the sensor's noise."""

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


def design_experiment(model: Model, target: Chosen, rival: Chosen) -> Experiment | None:
    """Return the motion, of many within the joints' limits, on which a cause and its rival differ most.

    Both are fitted to the log with everything else.  None where they differ nowhere by more than on the log itself.
    """
    gap = model.gap
    rest = tuple(choice for choice in model.chosen if choice.key != target.key)
    robots = [extend_robot(model), extend_robot(build_model(gap, model.nuisance, (*rest, rival)))]
    on_log, _ = _apart(gap, robots, None)
    best: Experiment | None = None
    for trajectory in candidates(gap, target.site.joint):
        apart, joint = _apart(gap, robots, trajectory)
        if apart > on_log and (best is None or apart > best.apart):
            between = (target.cause.name, rival.cause.name)
            best = Experiment(trajectory, gap.robot.joints[joint], apart, on_log, between)
    return best


def candidates(gap: Gap, joint: int) -> list[Trajectory]:
    """Return motions within the joints' limits: all joints at several speeds and places, and one joint to and fro."""
    middle, reach = _room(gap.body)
    top = FASTER * np.max(np.abs(gap.motion.velocity), axis=0)
    names = gap.robot.joints
    out = [
        excitation(names, middle, reach, np.maximum(top * pace, 1e-3), SECONDS, seed=seed)
        for pace in (0.15, 1.0)
        for seed in range(SEEDS)
    ]
    # A pass to and fro takes four reaches over its speed; slower than this no one waits for.
    slowest = 4.0 * reach[joint] / LONGEST_PASS
    fastest = max(min(top[joint], 4.0 * reach[joint]), 1.01 * slowest)
    speeds = np.geomspace(slowest, fastest, PASSES).tolist()
    alone = forward_backward(names[joint], middle[joint] - reach[joint], 2.0 * reach[joint], speeds, 4.0 * fastest)
    still = np.tile(middle, (alone.time.size, 1))
    still[:, joint] = alone.position[:, 0]
    return [*out, Trajectory(names, alone.time, still)]


def _room(body: Body) -> tuple[Floats, Floats]:
    low = np.where(np.isfinite(body.lower), body.lower, -np.pi)
    high = np.where(np.isfinite(body.upper), body.upper, np.pi)
    return 0.5 * (low + high), np.minimum(REACH * (high - low), WIDEST)


def _apart(gap: Gap, robots: list[Robot], trajectory: Trajectory | None) -> tuple[float, int]:
    if trajectory is None:
        motion = gap.motion
    else:
        columns = {"time": trajectory.time}
        for i, name in enumerate(trajectory.joints):
            columns[f"{POSITION}.{name}"] = trajectory.position[:, i]
            columns[f"{EFFORT}.{name}"] = np.zeros(trajectory.time.size)
        motion = estimate_motion(log_from_table(pa.table(columns), "experiment"), gap.robot.joints, CUTOFF)
    one, other = (predict_effort(robot, robot.body(), motion).reported for robot in robots)
    size = np.sqrt(np.mean(np.square(one - other), axis=0))[list(gap.examined)]
    noise = np.maximum(gap.noise_floor[list(gap.examined)] / gap.chain.noise_gain, 1e-9)
    worst = int(np.argmax(size / noise))
    return float((size / noise)[worst]), gap.examined[worst]
