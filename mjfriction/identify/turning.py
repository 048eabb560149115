"""Speeds below which friction laws do not hold, on machines whose friction vanishes while they creep."""

from __future__ import annotations

import functools
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import lsq_linear
from scipy.stats import norm, wilcoxon

from mjfriction.record.log import Floats
from mjfriction.record.runs import spans

SPEEDS = np.geomspace(0.0015, 0.03, 16)  # shares of the fastest speed that are tried
FARTHER = np.geomspace(0.0015, 0.3, 28)  # the same of a joint that is fast or creeps, and nothing between
# It is that where of its rows below the usual share of its fastest speed nearly all are below this one.
CREEPING, NEARLY_ONLY = 0.15, 0.8
MOST_OFF = 0.3  # its level and its damping may then be off by this share of the level, each at its fastest speed
# Share of the fastest speed, up to which the stated curve is straight enough to be corrected by two numbers.
USUAL = 0.4
TURNED = 3.0  # times the turning speed, above which tanh is 1 to half a percent
FEWEST_ROWS, FEWEST_SLOW = 30, 8  # rows of a joint, and rows within which friction turns
# Standard deviations of the mean, over visits of slow motion, by which the error removed must be above zero.
SURELY = 2.5
SHARE = 0.25  # share of the error in slow motion that must be removed
# Share of what friction that builds up over travel leaves, that a joint alone in showing it may leave at most.
ALONE = 0.7
TRAVELS = np.geomspace(1e-4, 0.1, 14)  # shares of the longest way without a turn, over which friction may build up
NEARLY_ALL = 0.75  # share of the error in slow motion whose removal is enough, however few the visits
FEWEST_JOINTS, ALL_BUT = 3, 0.5  # joints that must show it, or two and at least this share of those measured


def turning_speeds(
    velocity: Floats, travel: Floats, residual: Floats, clear: NDArray[np.bool_], level: Floats, top: Floats
) -> Floats:
    """Return the speed below which each joint's friction has not reached its level, (joints,), 0 where it always has.

    A joint that stops slowly, or sags while it is held, creeps.  Friction modelled as level·tanh(v/v_t), as in many
    simulations, then falls to nothing, and so does the friction of an oil film.  There, a law with a jump at zero is
    off by its whole level, in whichever direction.  This is not a fault of one joint: where most joints show it, what
    they do below 3·v_t is not counted against any law.  The other joints get the lowest turning speed of these, in m or
    rad per second or as a share of their fastest speed, whichever is less.  A joint that alone shows it, because the
    others never creep, must show it more clearly than friction that builds up over travel would.  Beside such a joint
    it is enough for another one to show it likewise, in however few visits of slow motion.

    ``velocity``, ``travel`` since the last turn, ``residual`` and ``clear`` (the rows not in doubt so far) are (rows,
    joints).  ``level`` (joints,) is the friction that a joint is stated to hold at rest, ``top`` (joints,) its top
    speed.
    """
    measured = np.flatnonzero(np.isfinite(residual[0]) & (level > 0.0) & (top > 0.0))
    found, likely, alone = {}, {}, False
    for joint in measured.tolist():
        slow = _slow_rows(velocity[:, joint] / top[joint], residual[:, joint] / level[joint], clear[:, joint])
        turning = slow.turning() if slow is not None else 0.0
        if slow is None or turning == 0.0:
            continue
        if slow.surely():
            found[joint] = turning
        if slow.beyond(travel[:, joint]):
            likely[joint] = turning
            alone = alone or joint in found
    out = np.zeros_like(top)
    if len(found) < min(FEWEST_JOINTS, max(2, int(np.ceil(ALL_BUT * measured.size)))):
        for joint, share in likely.items() if alone else ():
            out[joint] = TURNED * share * top[joint]
        return out
    slowest = min(share * top[joint] for joint, share in found.items())
    for joint in measured.tolist():
        share = found.get(joint, 0.0)
        out[joint] = TURNED * (share * top[joint] if share else min(slowest, min(found.values()) * top[joint]))
    return out


@dataclass(frozen=True)
class _SlowRows:
    """Rows of slow motion: which they are (``rows``), and their values.

    ``ahead`` is the speed, as a share of the fastest; ``lost`` is the residual along the motion, as a share of the
    level, negative where friction is lacking.  A joint that is fast or creeps, and nothing between (``apart``), has all
    of its rows here, with level and damping near what is stated: with speeds of two kinds, they could be anything.
    """

    rows: NDArray[np.bool_]
    ahead: Floats
    lost: Floats
    apart: bool = False

    @functools.cached_property
    def _best(self) -> tuple[float, Floats]:
        # The best share of the fastest speed within which friction turns over, and the squared errors that it leaves.
        shares = FARTHER if self.apart else SPEEDS
        lefts = [self._squares(1.0 - np.tanh(self.ahead / share)) for share in shares]
        best = int(np.argmin([np.sum(left) for left in lefts]))
        return float(shares[best]), lefts[best]

    def _squares(self, missing: Floats) -> Floats:
        # The squared errors, relative to the level, of a model that lacks a share of the level; level and damping are
        # refitted.
        columns = np.column_stack([1.0 - missing, self.ahead])
        wanted = self.lost + missing
        if self.apart:
            fitted = lsq_linear(columns, wanted, (-MOST_OFF, MOST_OFF)).x
        else:
            fitted = np.linalg.lstsq(columns, wanted, rcond=None)[0]
        return np.asarray(np.square(wanted - columns @ fitted))

    def turning(self) -> float:
        """Return the share of the fastest speed within which friction turns over, 0 where none explains the error."""
        as_stated = self._squares(np.zeros_like(self.ahead))
        share, left = self._best
        slow = self.ahead < TURNED * share
        taken = np.sum((as_stated - left)[slow])
        return share if np.sum(slow) >= FEWEST_SLOW and taken >= SHARE * np.sum(as_stated[slow]) else 0.0

    def surely(self) -> bool:
        """Return whether the error that is explained is surely no chance."""
        as_stated = self._squares(np.zeros_like(self.ahead))
        share, left = self._best
        taken, slow = as_stated - left, self.ahead < TURNED * share
        everywhere, gained = np.zeros(self.rows.size, dtype=bool), np.zeros(self.rows.size)
        everywhere[np.flatnonzero(self.rows)[slow]] = True
        gained[np.flatnonzero(self.rows)] = taken
        visits = np.array([np.sum(gained[first:past]) for first, past in spans(everywhere)])
        # A few long visits dominate the deviation.  The result is as sure where nearly all visits gain, or where nearly
        # all of the error is removed.
        sure = visits.size > 2 and np.mean(visits) > SURELY * np.std(visits, ddof=1) / np.sqrt(visits.size)
        sure = sure or wilcoxon(visits, alternative="greater").pvalue < norm.sf(SURELY)
        return bool(sure or np.sum(taken[slow]) > NEARLY_ALL * np.sum(as_stated[slow]))

    def beyond(self, travel: Floats) -> bool:
        """Return whether friction that turns over with speed leaves far less than friction that builds up over travel.

        ``travel`` is the way since the last turn, at all rows.
        """
        own = np.maximum(travel[self.rows], 0.0)  # at a turn the rows' filter rings below zero
        reaches = np.max(travel) * TRAVELS
        least = min(float(np.sum(self._squares(np.exp(-own / reach)))) for reach in reaches)
        return bool(np.sum(self._best[1]) < ALONE * least)


def _slow_rows(speed: Floats, error: Floats, clear: NDArray[np.bool_]) -> _SlowRows | None:
    moving = clear & (speed != 0.0)
    rows = moving & (np.abs(speed) < USUAL)
    if np.sum(rows) < FEWEST_ROWS:
        return None
    apart = bool(np.mean(np.abs(speed[rows]) < CREEPING) >= NEARLY_ONLY)
    rows = moving if apart else rows
    return _SlowRows(rows, np.abs(speed[rows]), error[rows] * np.sign(speed[rows]), apart)
