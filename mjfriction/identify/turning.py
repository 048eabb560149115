"""Machines whose friction vanishes while they creep: below which speeds their laws do not hold."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mjfriction.record.faults import spans
from mjfriction.record.log import Floats

SPEEDS = np.geomspace(0.0015, 0.03, 16)  # of the fastest speed, that are tried
USUAL = 0.4  # of the fastest speed, up to which the stated curve is straight enough to be put right by two numbers
TURNED = 3.0  # times the speed of turning, from which on tanh is 1 to half a percent
FEWEST_ROWS, FEWEST_SLOW = 50, 8  # of a joint, and of those within which friction turns
SURELY = 2.5  # deviations over visits of slow motion, that the error taken away must be above none
SHARE = 0.25  # of the error in slow motion, that it must take away
FEWEST_JOINTS, ALL_BUT = 3, 0.5  # joints that must show it, or two and at least this share of those measured


def turning_speeds(velocity: Floats, residual: Floats, clear: NDArray[np.bool_], level: Floats, top: Floats) -> Floats:
    """Return the speed below which each joint's friction has not reached its level, (joints,), 0 where it always has.

    A joint that is slow to stop, or sags while it is held, creeps.  Friction that is written as level·tanh(v/v_t), as
    many simulations write it, then falls to nothing, and so does that of a film of oil; a law with a jump at zero is
    off by its whole level there, in whichever direction.  That is nothing that is wrong with one joint: where most
    joints show it, what they do below 3·v_t is not held against any law.  The others are taken to turn as fast as the
    fastest of these, in m or rad per second or as a share of their fastest speed, whichever is less.

    ``velocity``, ``residual`` and ``clear`` are (rows, joints), the last telling which rows are in no doubt so far;
    ``level`` (joints,) is what a joint's friction is stated to hold at rest, ``top`` (joints,) its top speed.
    """
    measured = np.flatnonzero(np.isfinite(residual[0]) & (level > 0.0) & (top > 0.0))
    found = {}
    for joint in measured:
        own = clear[:, joint]
        turning = _turning(velocity[:, joint] / top[joint], residual[:, joint] / level[joint], own)
        if turning > 0.0:
            found[int(joint)] = turning
    out = np.zeros_like(top)
    if len(found) < min(FEWEST_JOINTS, max(2, int(np.ceil(ALL_BUT * measured.size)))):
        return out
    slowest = min(share * top[joint] for joint, share in found.items())
    for joint in measured:
        share = found.get(int(joint), 0.0)
        out[joint] = TURNED * (share * top[joint] if share else min(slowest, min(found.values()) * top[joint]))
    return out


def _turning(speed: Floats, error: Floats, clear: NDArray[np.bool_]) -> float:
    # The share of the fastest speed within which friction turns over, 0 where no such speed explains what is left.
    rows = clear & (np.abs(speed) < USUAL) & (speed != 0.0)
    if np.sum(rows) < FEWEST_ROWS:
        return 0.0
    ahead, lost = np.abs(speed[rows]), error[rows] * np.sign(speed[rows])
    as_stated = np.square(_left(ahead, lost, np.zeros_like(ahead)))
    lefts = [np.square(_left(ahead, lost, 1.0 - np.tanh(ahead / share))) for share in SPEEDS]
    best = int(np.argmin([np.sum(left) for left in lefts]))
    share, taken = float(SPEEDS[best]), as_stated - lefts[best]
    slow = ahead < TURNED * share
    if np.sum(slow) < FEWEST_SLOW or np.sum(taken[slow]) < SHARE * np.sum(as_stated[slow]):
        return 0.0
    everywhere, gained = np.zeros(speed.size, dtype=bool), np.zeros(speed.size)
    everywhere[np.flatnonzero(rows)[slow]] = True
    gained[np.flatnonzero(rows)] = taken
    visits = np.array([np.sum(gained[first:past]) for first, past in spans(everywhere)])
    if visits.size < 3:
        return 0.0
    deviation = float(np.std(visits, ddof=1)) / np.sqrt(visits.size)
    return share if float(np.mean(visits)) > SURELY * deviation else 0.0


def _left(speed: Floats, lost: Floats, missing: Floats) -> Floats:
    # What is left of an error relative to the level, a share of which is missing; level and damping are refitted.
    columns = np.column_stack([1.0 - missing, speed])
    wanted = lost + missing
    return np.asarray(wanted - columns @ np.linalg.lstsq(columns, wanted, rcond=None)[0])
