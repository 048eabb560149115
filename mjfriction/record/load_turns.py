"""Turns of a load: changes of sign from clearly one side to clearly the other."""

from __future__ import annotations

import functools
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import binom

from mjfriction.record.log import Floats, Integers
from mjfriction.record.motion import Motion

# Of the position filter's cutoff; the load is low-passed there, which removes the apparent acceleration of jumps and
# blows.
SLOW_LOAD = 0.08
CLEARLY = 0.02  # of its maximum; a load this close to zero has no clear sign, as it may rest there
NEAR = 0.1  # s, largest time error of a turn of the predicted load


@dataclass(frozen=True)
class LoadTurns:
    """Turns of a load along a motion, whose number of ``samples`` and ``rate`` (Hz) are kept.

    Of each turn, (turns,): the samples at which the load ``left`` one side and ``reached`` the other, and the sign
    ``to`` which it turned, −1 or 1.  ``through`` (passages,) are the samples at which it went through zero in between,
    of turns in which it did so once: of a load that rests near zero, noise decides when that is.
    """

    left: Integers
    reached: Integers
    to: Floats
    through: Integers
    samples: int
    rate: float

    @property
    def count(self) -> int:
        """The number of turns."""
        return self.to.size

    def meet(self, at: Integers, way: Floats) -> NDArray[np.bool_]:
        """Return which moments, as samples ``at``, lie near a turn in the same direction ``way``, (moments,)."""
        near = NEAR * self.rate
        within = (at[:, None] >= self.left - near) & (at[:, None] <= self.reached + near)
        return np.asarray(np.any(within & (self.to == np.sign(way)[:, None]), axis=1))

    def near(self, seconds: float) -> NDArray[np.bool_]:
        """Return which samples lie within so many ``seconds`` of a turn's beginning, passage or end, (samples,)."""
        moments = np.concatenate([self.left, self.through, self.reached])
        return self._around(moments, moments, seconds)

    @functools.cached_property
    def _share(self) -> float:
        # The share of all samples that lie near a turn.
        return float(np.mean(self._around(self.left, self.reached, NEAR)))

    def _around(self, first: Integers, last: Integers, seconds: float) -> NDArray[np.bool_]:
        # The samples from so many seconds before the first to as many after the last of some stretches, (samples,).
        near, lies = round(seconds * self.rate), np.zeros(self.samples, dtype=bool)
        for begin, end in zip(first, last, strict=True):
            lies[max(begin - near, 0) : end + near + 1] = True
        return lies

    def chance(self, met: NDArray[np.bool_]) -> float:
        """Return the probability that at least as many moments meet a turn of their direction by chance."""
        return float(binom.sf(np.sum(met) - 1, met.size, 0.5 * self._share))


def load_turns(motion: Motion, load: Floats) -> LoadTurns:
    """Return the turns of a load (n,) along a motion."""
    slow = motion.low_passed(load, SLOW_LOAD * motion.cutoff)
    clear = np.flatnonzero(np.abs(slow) > CLEARLY * np.max(np.abs(slow), initial=0.0))
    side = np.sign(slow[clear])
    turns = np.flatnonzero((np.diff(side) != 0.0) & (np.diff(motion.piece[clear]) == 0))
    left, reached = clear[turns], clear[turns + 1]
    zeros = np.flatnonzero(np.diff(np.sign(slow)) != 0.0)
    first, past = np.searchsorted(zeros, left), np.searchsorted(zeros, reached)
    return LoadTurns(left, reached, side[turns + 1], zeros[first[past == first + 1]], load.size, motion.rate)
