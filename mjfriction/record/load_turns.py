"""Turns of a load: from clearly one side to clearly the other."""

from __future__ import annotations

import functools
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import binom

from mjfriction.record.log import Floats, Integers
from mjfriction.record.motion import Motion

SLOW_LOAD = 0.08  # of the position filter's cutoff: the load, without what jumps and blows seem to accelerate
CLEARLY = 0.02  # of its most, that a load lies beyond zero: within it rests as well as crosses
NEAR = 0.1  # s, within which the load as predicted turns when it really does


@dataclass(frozen=True)
class LoadTurns:
    """Turns of a load along a motion of so many ``samples`` at ``rate`` (Hz): the samples at which it ``left`` a side
    and ``reached`` the other, and which that is, ``to`` −1 or 1, (turns,) each.
    """

    left: Integers
    reached: Integers
    to: Floats
    samples: int
    rate: float

    @property
    def count(self) -> int:
        """How many there are."""
        return self.to.size

    def meet(self, at: Integers, way: Floats) -> NDArray[np.bool_]:
        """Return which of some moments, as samples, lie near a turn the same ``way``, (moments,)."""
        near = NEAR * self.rate
        within = (at[:, None] >= self.left - near) & (at[:, None] <= self.reached + near)
        return np.asarray(np.any(within & (self.to == np.sign(way)[:, None]), axis=1))

    @functools.cached_property
    def _share(self) -> float:
        # Of all moments, that lie near a turn.
        near, lies = round(NEAR * self.rate), np.zeros(self.samples, dtype=bool)
        for left, reached in zip(self.left, self.reached, strict=True):
            lies[max(left - near, 0) : reached + near + 1] = True
        return float(np.mean(lies))

    def chance(self, met: NDArray[np.bool_]) -> float:
        """Return how likely as many moments meet a turn of their way as do, had they nothing to do with it."""
        return float(binom.sf(np.sum(met) - 1, met.size, 0.5 * self._share))


def load_turns(motion: Motion, load: Floats) -> LoadTurns:
    """Return the turns of a load (n,) along a motion."""
    slow = motion.low_passed(load, SLOW_LOAD * motion.cutoff)
    clear = np.flatnonzero(np.abs(slow) > CLEARLY * np.max(np.abs(slow), initial=0.0))
    side = np.sign(slow[clear])
    turns = np.flatnonzero((np.diff(side) != 0.0) & (np.diff(motion.piece[clear]) == 0))
    return LoadTurns(clear[turns], clear[turns + 1], side[turns + 1], load.size, motion.rate)
