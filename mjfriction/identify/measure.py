"""Measuring the gap between a log and a robot: which rows of which joints count, and how far."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from mjfriction.body.model import Body
from mjfriction.errors import LogError
from mjfriction.identify.blocks import Blocks, cut_blocks
from mjfriction.identify.blows import blows
from mjfriction.identify.doubt import (
    CLEAR,
    WITHIN,
    YIELDING,
    doubt_speeds,
    rows_of_rests,
    share_in_doubt,
    unusable_rows,
)
from mjfriction.identify.effort_band import filtered_from, whole_below
from mjfriction.identify.gap import Gap, Known
from mjfriction.identify.rows import Chain, make_chain
from mjfriction.identify.turning import turning_speeds
from mjfriction.record.log import Floats, Log, check_joints
from mjfriction.record.motion import Motion
from mjfriction.record.noise import raw_noise
from mjfriction.record.resample import SHORTEST_PIECE
from mjfriction.record.reversals import travel_since_turn
from mjfriction.robot.bandwidth import HIGHEST, choose_cutoff
from mjfriction.robot.effort import (
    Effort,
    effort_per_reported,
    later,
    predict_effort,
)
from mjfriction.robot.measured_motion import measured_motion
from mjfriction.robot.robot import Robot
from mjfriction.robot.rubbing import resting_level, unsettled_along

# A joint that has both a smaller share of clear rows and fewer clear rows than these is judged on that share of its
# rows, the least doubtful ones.
FEWEST_CLEAR, ENOUGH_CLEAR = 0.2, 50
MOST_SPOILT = 0.9  # a joint is not examined where more than this share of its faster rows is unusable
HOPELESS = 1e6  # times the joint's largest effort: the doubt given to a row that says nothing
ENOUGH_PER_PERIOD = 4.0  # samples per period of the position filter's cutoff that leave the rows unchanged


def measure_gap(
    log: Log, robot: Robot, *, yielding: float = YIELDING, highest: float = HIGHEST, heeding: bool = False
) -> Gap:
    """Compare a log with a robot.

    ``yielding`` is the share of its stroke within which a joint's friction is in doubt after it has rested, or while it
    settles; 0 where laws are fitted that say how friction builds up.  ``highest`` is the upper limit of the position
    filter's cutoff (Hz).  With ``heeding``, rows with blows count like any other.

    Raises :class:`LogError` when the log is not of this robot, nothing moves or nothing that moves reports a usable
    effort, or the log is too short; :class:`~mjfriction.errors.RobotError` when the robot's model cannot be read.
    """
    body = robot.body()
    robot = robot.with_stated_friction(body)
    check_joints(log, robot.name, robot.joints)
    motion = measured_motion(log, robot, body, choose_cutoff(log, robot, body, highest))
    effort = predict_effort(robot, body, motion)
    torque = motion.torque * _per_reported(robot, motion)
    filtered = filtered_from(motion, effort, torque)
    chain = make_chain(motion, log.source, whole_below(filtered))
    blocks = cut_blocks(chain, chain.rows(motion.position), log.source)
    gap = _judging(_held_against(log, robot, body, motion, effort, chain, blocks, filtered, yielding, heeding))
    if not gap.examined:
        raise LogError(
            f"{log.source}: no joint moves for a while and reports an effort or a current that changes meanwhile; "
            "record motion that neither creeps nor jumps from rest to rest, with what the drives give"
        )
    return gap


def thinned(gap: Gap) -> Gap:
    """Return the gap on only as many samples as its rows need, to make further work faster and smaller."""
    motion = gap.motion.thinned(thinning(gap.motion))
    if motion is gap.motion:
        return gap
    return gap_on(gap, motion, lambda chain: cut_blocks(chain, chain.rows(motion.position), gap.log.source))


def gap_on(gap: Gap, motion: Motion, cut: Callable[[Chain], Blocks]) -> Gap:
    """Return the gap of the same robot along a part of the same motion, its rows ``cut`` into blocks."""
    chain = make_chain(motion, gap.log.source, whole_below(gap.filtered))
    effort = predict_effort(gap.robot, gap.body, motion)
    return _judging(_again(gap, gap.robot, gap.body, motion, effort, chain, cut(chain)))


def thinning(motion: Motion) -> int:
    """Return the factor by which a motion's samples may be thinned."""
    shortest = int(min(own.stop - own.start for own in motion.pieces))
    return max(1, min(int(motion.rate / (ENOUGH_PER_PERIOD * motion.cutoff)), shortest // SHORTEST_PIECE))


def gap_of(robot: Robot, along: Gap) -> Gap:
    """Return the gap of another robot with the same joints along the same motion, row by row."""
    return gap_along(robot, along.motion, along)


def gap_along(robot: Robot, motion: Motion, along: Gap) -> Gap:
    """Return the gap of another robot with the same joints along another estimate of the same motion, row by row."""
    body = robot.body()
    robot = robot.with_stated_friction(body)
    effort = predict_effort(robot, body, motion)
    gap = _again(along, robot, body, motion, effort, along.chain, along.blocks)
    # Examine the same joints: where no row of a joint is clear with this robot (or none was before), the joint keeps
    # the clear rows of ``along``.
    both = np.any(gap.clear, axis=0) & np.any(along.clear, axis=0)
    return _judging(replace(gap, clear=np.where(both, gap.clear, along.clear)))


def heard_later(gap: Gap, late: Floats) -> Gap:
    """Return the gap with drives that report later than stated by ``late`` (joints,), s.

    Residual and prediction stay.  The columns set beside them, and the rows where friction's direction is in doubt, are
    delayed.
    """
    table = gap.robot.table
    joints = tuple(later(joint, float(more)) for joint, more in zip(table.joint, late, strict=True))
    heard = gap_of(replace(gap.robot, table=table.model_copy(update={"joint": joints})), gap)
    return gap.delayed(late, heard.doubt, heard.clear)


def _judging(gap: Gap) -> Gap:
    # Set the measurement of joints without any clear row to NaN, so that they are not examined.
    judged = np.any(gap.clear, axis=0)
    measured, residual = (np.where(judged, values, np.nan) for values in (gap.measured, gap.residual))
    return replace(gap, measured=measured, residual=residual)


def _per_reported(robot: Robot, motion: Motion) -> Floats:
    pairs = zip(robot.table.joint, motion.quantity, strict=True)
    return np.array([effort_per_reported(joint, quantity, robot.name) for joint, quantity in pairs])


def _wholly_spoilt(unusable: NDArray[np.bool_], velocity: Floats) -> NDArray[np.bool_]:
    # Whether nearly all rows (rows, joints) of a joint at or above its median speed are unusable, (joints,).
    fast = np.abs(velocity) >= np.median(np.abs(velocity), axis=0)
    return np.asarray(np.sum(unusable & fast, axis=0) > MOST_SPOILT * np.sum(fast, axis=0))


def _again(gap: Gap, robot: Robot, body: Body, motion: Motion, effort: Effort, chain: Chain, blocks: Blocks) -> Gap:
    # A gap of the same log, measured with what differs.
    return _held_against(gap.log, robot, body, motion, effort, chain, blocks, gap.filtered, gap.yielding, gap.heeding)


def _held_against(
    log: Log,
    robot: Robot,
    body: Body,
    motion: Motion,
    effort: Effort,
    chain: Chain,
    blocks: Blocks,
    filtered: Floats,
    yielding: float,
    heeding: bool,
) -> Gap:
    per_reported = _per_reported(robot, motion)
    # Leave out drives that say nothing.  One that reports a constant has measured nothing.  One that holds its joint
    # still may report anything within the joint's friction.  One that hardly moves its joint says nothing about the
    # joint's laws.  One that clipped, or stuck, whenever its joint moved is of no use.
    still = ~motion.moving | motion.dawdling
    unusable = unusable_rows(log, motion, chain)
    still |= _wholly_spoilt(unusable, chain.rows(motion.velocity))
    told = np.where((np.ptp(motion.torque, axis=0) == 0.0) | still, np.nan, motion.torque)
    measured = chain.rows(told * per_reported)
    residual = measured - chain.rows(effort.reported)
    noise = [
        abs(per_reported[i]) * raw_noise(log, quantity, joint, motion.clock) if quantity else np.nan
        for i, (joint, quantity) in enumerate(zip(motion.joints, motion.quantity, strict=True))
    ]
    slow = doubt_speeds(motion)
    unsettled = unsettled_along(robot, motion, effort.load, effort.rotor)
    touched = share_in_doubt(robot, motion, chain, slow, yielding, unsettled)
    resting = resting_level(robot, motion, effort.load, effort.rotor, slow)
    travel = chain.rows(travel_since_turn(motion.velocity, motion.position, motion.pieces)[0])
    velocity = chain.rows(motion.velocity)
    turning = turning_speeds(velocity, travel, residual, touched < CLEAR, resting, motion.top_speed)
    if np.any(turning > slow):
        slow = np.maximum(slow, turning)
        touched = share_in_doubt(robot, motion, chain, slow, yielding, unsettled)
    # While its direction is unknown, friction may be as large as its stated level or as the RMS residual, whichever is
    # more.  A joint at rest holds one friction value all the time, so the many rows of a rest count as one observation.
    level = resting_level(robot, motion, effort.load, effort.rotor, slow)
    doubt = touched * np.maximum(level, np.sqrt(np.mean(np.square(np.nan_to_num(residual)), axis=0)))
    doubt *= np.sqrt(rows_of_rests(touched, chain))
    felt, struck = blows(body, motion, chain, slow)
    if heeding:
        felt, struck = np.zeros_like(felt), np.zeros_like(struck)
    doubt = doubt + felt
    spoilt = unusable | struck
    doubt = np.where(spoilt, HOPELESS * np.max(np.abs(np.nan_to_num(measured))), doubt)
    floor = np.array(noise) * np.sqrt(motion.rate * motion.clock.step) * chain.noise_gain
    clear = (touched < CLEAR) & (felt <= floor) & ~spoilt
    few = (np.mean(clear, axis=0) < FEWEST_CLEAR) & (np.sum(clear, axis=0) < ENOUGH_CLEAR)
    # Spoilt rows rank last.  Rows within a rest say nothing and are never taken.
    unclear = touched + spoilt
    clear[:, few] |= ((unclear <= np.quantile(unclear, FEWEST_CLEAR, axis=0)) & (unclear < WITHIN))[:, few]
    return Gap(
        robot=robot,
        body=body,
        log=log,
        motion=motion,
        effort=effort,
        chain=chain,
        measured=measured,
        residual=residual,
        noise_floor=floor,
        doubt=doubt,
        clear=clear,
        doubt_speed=slow,
        blocks=blocks,
        per_reported=per_reported,
        filtered=filtered,
        yielding=yielding,
        heeding=heeding,
        late=np.zeros(len(motion.joints)),
        known=Known(robot, body, effort),
    )
