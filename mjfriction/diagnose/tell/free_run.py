"""Free-run check: the logged efforts drive the stated and the extended robot in MuJoCo for short runs.

Each run starts where the machine was.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

import numpy as np

from mjfriction.diagnose.fit.extend import extend_robot
from mjfriction.diagnose.fit.model import Model
from mjfriction.errors import RobotError
from mjfriction.identify.doubt import unusable_rows
from mjfriction.identify.gap import Gap
from mjfriction.identify.proof import Gain, measure_gain
from mjfriction.identify.stretches import Cuts, missed, stretches_at
from mjfriction.record.log import Floats, Integers
from mjfriction.robot.robot import Robot

SECONDS = 0.25  # length of each run: nothing holds the joints on course, and within a second any arm drifts off it


@dataclass(frozen=True)
class FreeRun:
    """How far the joints end up from where the machine was, in runs of ``seconds`` each, at most one per block of
    motion.

    ``begin`` (runs,) is on the log's clock, and ``time`` (m,) counts from it. ``stated`` and ``extended`` (runs, m,
    joints) are the position errors in rad or m; the strengths of the extended robot are fitted to the other folds'
    blocks each time. ``gains`` holds the RMS errors of both robots in rad or m, by the index of each joint that is
    reported.
    """

    seconds: float
    begin: Floats
    time: Floats
    stated: Floats
    extended: Floats
    gains: dict[int, Gain]


def run_freely(model: Model, stated: Robot, seed: int, jumping: Collection[int] = ()) -> FreeRun:
    """Drive the ``stated`` robot and the one extended by a model freely along the model's log.

    ``seed`` sets the resampling behind the intervals. Joints whose sensors were seen ``jumping`` are not reported,
    since the motion is given without the jumps. Raises :class:`~mjfriction.errors.InputError` where a joint that moves
    has no effort, no block is long enough, a cause becomes inadmissible without a part of the log, or MuJoCo cannot
    hold a robot.
    """
    gap = model.gap
    cuts, block = _one_in_each_block(gap)
    fixed = stretches_at(gap, stated, cuts)
    off = missed(gap, [stated], fixed)[0]
    better = np.empty_like(off)
    for fold in gap.blocks.folds:
        own = np.flatnonzero(fold[block])
        if own.size:
            robot = extend_robot(model, _possible(model, model.built_from(~fold)))
            better[own] = missed(gap, [robot], stretches_at(gap, robot, cuts.some(own)))[0]
    each = np.repeat(block, off.shape[1])
    told = [i for i in gap.examined if i not in jumping]
    gains = {i: measure_gain(off[..., i].ravel(), better[..., i].ravel(), each, seed) for i in told}
    time = np.asarray(fixed.compared * fixed.step)
    return FreeRun(fixed.seconds, gap.motion.time[cuts.begins], time, off, better, gains)


def _possible(model: Model, strengths: Floats) -> Floats:
    for choice, place in zip(model.chosen, model.places, strict=True):
        if not choice.cause.admissible(model.gap, choice.site, strengths[place]):
            raise RobotError(f"{choice.cause.name} comes out as nature does not allow without a part of the log")
    return strengths


def _one_in_each_block(gap: Gap) -> tuple[Cuts, Integers]:
    # Place each run in the middle of its block's longest stretch without gaps, filter transients or unusable efforts.
    motion, blocks = gap.motion, gap.blocks
    spoilt = unusable_rows(gap.log, motion, gap.chain)[:, list(gap.examined)].any(axis=1)
    told = motion.settled & (np.interp(motion.time, gap.chain.time, spoilt.astype(np.float64)) == 0.0)
    length = round(SECONDS * motion.rate)
    begins, kept, of_block = [], [], _block_of_samples(gap)
    for block in range(blocks.count):
        samples = np.flatnonzero(told & (of_block == block))
        if not samples.size:
            continue
        apart = np.flatnonzero((np.diff(samples) > 1) | (np.diff(motion.piece[samples]) != 0)) + 1
        longest = max(np.split(samples, apart), key=len)
        if longest.size > length:
            begins.append(int(longest[(longest.size - length) // 2]))
            kept.append(block)
    if not begins:
        raise RobotError(f"{gap.log.source}: nowhere is there {SECONDS} s of motion between its gaps")
    return Cuts(np.array(begins), length), np.array(kept)


def _block_of_samples(gap: Gap) -> Integers:
    # The block of each sample of the motion, −1 where the row before it and the one after are not of one block.
    time, row = gap.chain.time, gap.blocks.row
    before = np.clip(np.searchsorted(time, gap.motion.time, side="right") - 1, 0, time.size - 2)
    within = (gap.motion.time >= time[0]) & (gap.motion.time < time[-1]) & (row[before] == row[before + 1])
    return np.where(within, row[before], -1)
