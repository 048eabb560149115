"""Where a joint's friction is unknown: at rest, at reversals, while its contact yields, and without usable effort."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mjfriction.identify.rows import Chain
from mjfriction.record.log import Floats, Log
from mjfriction.record.motion import Motion
from mjfriction.record.runs import spans
from mjfriction.robot.robot import Robot

# Of a joint's RMS speed while it moves; below it no law can be distinguished from its own smoothed step at zero.
DOUBT_SPEED = 0.02
DOUBT_PERIODS = 0.6  # periods of the position filter's cutoff over which a sign change is blurred
YIELDING = 1e-3  # share of the stroke over which any contact yields before it slides
LITTLE = 0.01  # share of the stroke: a joint that moves less between two turns rests, or settles
CLEAR = 0.1  # a row is clear where less than this share of its window is in doubt
WITHIN = 0.9  # a row lies within a rest where more than this share of its window is in doubt


def doubt_speeds(motion: Motion) -> Floats:
    """Return the speed below which the direction of each joint's friction is in doubt, (joints,).

    A joint that waits for others creeps meanwhile; that does not count towards its usual speed.
    """
    speed = np.abs(motion.velocity)
    moves = speed > DOUBT_SPEED * motion.top_speed
    usual = np.sqrt(np.sum(np.square(speed) * moves, axis=0) / np.maximum(np.sum(moves, axis=0), 1))
    return np.asarray(np.maximum(motion.resting_speed, DOUBT_SPEED * usual))


def share_in_doubt(
    robot: Robot, motion: Motion, chain: Chain, slow: Floats, yielding: float, unsettled: NDArray[np.bool_]
) -> Floats:
    """Return the share of each row's window near a reversal, at rest or just after a rest, 0 to 1, (rows, joints).

    It is delayed as much as the drive's reports are stated to be.  ``slow`` (joints,) are the speeds of
    :func:`doubt_speeds`.  ``yielding`` is the share of its stroke that a joint has to move after a rest before its
    friction is known; where it is ``unsettled`` (n, joints), its friction is not known either.
    """
    out = []
    courses = zip(robot.table.joint, motion.position.T, motion.velocity.T, slow, unsettled.T, strict=True)
    for joint, position, velocity, speed, unknown in courses:
        turns = np.flatnonzero(np.diff(np.sign(velocity)) != 0)
        near = near_turns(motion, velocity, speed) | unknown | _yields(motion, position, turns, yielding)
        out.append(chain.touched(heard(near, joint.effort_sensor.delay, motion)))
    return np.column_stack(out)


def heard(mask: NDArray[np.bool_], late: float, motion: Motion) -> NDArray[np.bool_]:
    """Return a mask (n,) of what a joint does where a sensor tells of it that is ``late`` (s), (n,)."""
    return mask[np.clip(np.arange(mask.size) - round(late * motion.rate), 0, mask.size - 1)]


def near_turns(motion: Motion, velocity: Floats, slow: float) -> NDArray[np.bool_]:
    """Return where a velocity (n,) is slower than ``slow``, or so near to a change of sign that the position filter
    blurs it, (n,).
    """
    reach = int(np.ceil(DOUBT_PERIODS * motion.rate / motion.cutoff))
    near = np.abs(velocity) < slow
    turns = np.flatnonzero(np.diff(np.sign(velocity)) != 0)
    for shift in range(-reach, reach + 1):
        near[np.clip(turns + shift, 0, near.size - 1)] = True
    return near


def _yields(motion: Motion, position: Floats, turns: NDArray[np.intp], share: float) -> NDArray[np.bool_]:
    # Where a joint that rested, or is about to, has not moved as far from its turn as its contact yields before it
    # slides, (n,).  A joint that turns as it swings to and fro yields over less than the filter blurs, so that is not
    # counted.
    begins = np.flatnonzero(np.diff(motion.piece, prepend=motion.piece[0] - 1))
    starts = np.union1d(begins, turns + 1)
    moved = np.abs(np.diff(position[np.append(starts, position.size - 1)]))
    little = moved < LITTLE * np.ptp(position)
    little |= np.append(True, little[:-1])  # or the move before it was little
    way = np.repeat(np.arange(starts.size), np.diff(np.append(starts, position.size)))
    return np.asarray(little[way] & (np.abs(position - position[starts][way]) < share * np.ptp(position)))


def rows_of_rests(share: Floats, chain: Chain) -> Floats:
    """Return how many consecutive rows lie within the same rest as a row, 1 for rows outside rests, (rows, joints).

    A joint at rest holds one friction value all the time, so many rows are one observation.  ``share`` (rows, joints)
    is that of :func:`share_in_doubt`.
    """
    out = np.ones_like(share)
    for piece in np.unique(chain.piece):
        rows = np.flatnonzero(chain.piece == piece)
        for joint, own in enumerate(share[rows].T):
            for first, past in spans(own > WITHIN):
                out[rows[first:past], joint] = past - first
    return out


def unusable_rows(log: Log, motion: Motion, chain: Chain) -> NDArray[np.bool_]:
    """Return which rows contain samples of a joint's effort that were recorded but say nothing, (rows, joints)."""
    out = np.zeros((chain.time.size, len(motion.joints)), dtype=bool)
    for i, (joint, quantity) in enumerate(zip(motion.joints, motion.quantity, strict=True)):
        mask = log.unusable.get(f"{quantity}.{joint}")
        if mask is not None:
            on_grid = [
                np.interp(grid.time, log.time[grid.rows], mask[grid.rows].astype(np.float64)) for grid in motion.grids
            ]
            out[:, i] = chain.touched(np.concatenate(on_grid) > 0.0) > 0.0
    return out
