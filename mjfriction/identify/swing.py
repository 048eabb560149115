"""A load that swings, driven by its joint's acceleration: a liquid that sloshes, a tool that hangs from a cable."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
from scipy.signal import lfilter

from mjfriction.identify.gap import Gap
from mjfriction.record.log import Floats, Integers

SLOWEST, FASTEST = 0.3, 5.0  # Hz, of the frequencies that are tried
IN_BAND = 0.8  # share of the rows' band that the frequency may reach
FEWEST_TURNS = 10.0  # periods that the longest stretch of rows must contain
DAMPING_RATIOS = (0.01, 0.03, 0.09)
APART = 1.5  # relative distance of the frequencies tried, in damping ratios
BROADER = 2.0  # factor by which a tuned damping ratio may lie above or below those tried
SLACK = 1e-9  # relative tolerance at the ends of the range of frequencies
FEWEST_LINES = 2.0  # overtones of a motion that repeats, which a resonance must span
MOST_STRETCHES = 4  # the longest stretches, in which a load may already be swinging at the start
GAP = 1.5  # steps between two rows, up to which they belong together


@dataclass(frozen=True)
class Swing:
    """A load that swings at ``frequency`` (Hz) with a ``damping_ratio``, and pulls at its ``joint``.

    Its deflection x obeys ẍ + 2ζω·ẋ + (1 + ζ²)·ω²·x = -q̈ with ω = 2πf and the joint's acceleration q̈; its pull is
    proportional to x.
    """

    joint: int
    frequency: float
    damping_ratio: float

    @property
    def words(self) -> str:
        """A description in words."""
        return f"a load that swings at {self.frequency:.3g} Hz"

    def columns(self, gap: Gap) -> Floats:
        """Return its course from rest at the rows, and how a swing already begun would go on, (rows, k).

        The first column is driven.  Two more are free, for each of the longest stretches of rows without a gap.
        """
        return courses(gap, [self])[:, 0]


@dataclass(frozen=True)
class Shown:
    """The swinging loads that a log can show.

    They are those between two frequencies (Hz).  Where the motion repeats after ``period`` (s), their resonance must
    also span two of its overtones: otherwise anything that moves at one of these may be the cause.
    """

    slowest: float
    fastest: float
    period: float | None

    def holds(self, swing: Swing) -> bool:
        """Return whether a log can show this swing."""
        inside = self.slowest * (1.0 - SLACK) <= swing.frequency <= self.fastest * (1.0 + SLACK)
        sharp = DAMPING_RATIOS[0] / BROADER <= swing.damping_ratio <= DAMPING_RATIOS[-1] * BROADER
        width = 2.0 * swing.damping_ratio * swing.frequency
        return inside and sharp and (self.period is None or width * self.period > FEWEST_LINES)

    def swings(self, joint: int) -> list[Swing]:
        """Return swings of a joint to try, as closely spaced as their resonances are sharp."""
        out = []
        for ratio in DAMPING_RATIOS if self.fastest > self.slowest else ():
            count = 1 + int(np.ceil(np.log(self.fastest / self.slowest) / (APART * ratio)))
            tried = np.geomspace(self.slowest, self.fastest, count)
            out += [Swing(joint, float(frequency), ratio) for frequency in tried]
        return [one for one in out if self.holds(one)]


def shown_swings(gap: Gap) -> Shown:
    """Return which swinging loads a log can show: those that swing often enough in it, within the rows' band."""
    longest = float(np.max(np.diff(_starts(gap)))) * gap.chain.step
    return Shown(max(SLOWEST, FEWEST_TURNS / longest), min(FASTEST, IN_BAND * gap.chain.band), gap.blocks.period)


def courses(gap: Gap, tried: list[Swing], every: int = 1) -> Floats:
    """Return the columns of swings of one joint at each ``every``-th row, (rows/every, swings, k), each of RMS 1.

    The filters of rows and sensors do not matter: the acceleration passes through the same ones, and so does anything
    that follows it linearly.
    """
    time = gap.chain.time
    acceleration = gap.motion.acceleration[:, [tried[0].joint]]
    pull = gap.reported(tried[0].joint, acceleration)[:, 0].astype(complex)
    starts, step = _starts(gap), gap.chain.step
    longest = np.sort(np.argsort(np.diff(starts))[::-1][:MOST_STRETCHES])
    out = np.zeros((-(-time.size // every), len(tried), 1 + 2 * longest.size))
    for k, swing in enumerate(tried):
        pole = 2.0 * np.pi * swing.frequency * complex(-swing.damping_ratio, 1.0)
        turn = np.exp(pole * step)
        # Exact for an acceleration that is linear from row to row.
        now = (turn - 1.0 - pole * step) / (pole**2 * step)
        before = (1.0 - turn + turn * pole * step) / (pole**2 * step)
        driven, free = np.empty(time.size), np.zeros((time.size, 2 * longest.size))
        for i, (first, past) in enumerate(itertools.pairwise(starts)):
            own = pull[first:past]
            driven[first:past] = -lfilter([now, before], [1.0, -turn], own, zi=[-now * own[0]])[0].imag
            if i in longest:
                place = 2 * int(np.searchsorted(longest, i))
                going = np.exp(pole * (time[first:past] - time[first]))
                free[first:past, place : place + 2] = np.column_stack([going.real, going.imag])
        out[:, k] = np.column_stack([driven, free])[::every]
    out /= np.maximum(np.sqrt(np.mean(np.square(out), axis=0)), 1e-300)
    return out


def _starts(gap: Gap) -> Integers:
    # Where stretches of rows without a gap begin, and the end of the last.
    time = gap.chain.time
    breaks = np.flatnonzero(np.diff(time) > GAP * gap.chain.step) + 1
    return np.concatenate([[0], breaks, [time.size]])
