"""A load that swings, driven by its joint's acceleration: a liquid that sloshes, a tool that hangs from a cable."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
from scipy.signal import lfilter

from mjfriction.identify.gap import Gap
from mjfriction.identify.structure import covariate_rows
from mjfriction.record.log import Floats

SLOWEST, FASTEST = 0.3, 5.0  # Hz, of those that are tried
IN_BAND = 0.8  # of the rows' band, that its frequency may reach
FEWEST_TURNS = 10.0  # of it, that the rows must hold
DAMPING_RATIOS = (0.01, 0.03, 0.09)
APART = 1.5  # damping ratios between the frequencies that are tried
FINER, SHARPER = np.linspace(-0.5, 0.5, 5), 3.0 ** np.linspace(-0.5, 0.5, 5)
FEWEST_LINES = 2.0  # of a motion that repeats, that a resonance must span


@dataclass(frozen=True)
class Swing:
    """A load that swings at ``frequency`` (Hz) with a ``damping_ratio``, and pulls at its ``joint``.

    Its course x obeys ẍ + 2ζω·ẋ + (1 + ζ²)·ω²·x = -q̈ with ω = 2πf and the joint's acceleration q̈; its pull is in
    proportion to x.
    """

    joint: int
    frequency: float
    damping_ratio: float

    @property
    def words(self) -> str:
        """What it is, in words."""
        return f"a load that swings at {self.frequency:.3g} Hz"

    def columns(self, gap: Gap) -> Floats:
        """Return its course at the rows, in units of its RMS, (rows, 1)."""
        return courses(gap, [self])

    def finer(self) -> list[Swing]:
        """Return the swings around this one, half of what :func:`swings` keeps between them."""
        return [
            Swing(self.joint, self.frequency * float(1.0 + APART * self.damping_ratio * shift), float(ratio))
            for shift in FINER
            for ratio in self.damping_ratio * SHARPER
        ]


def swings(gap: Gap, joint: int) -> list[Swing]:
    """Return the swings at a joint that a log can show, as close as their resonances are sharp.

    Where a motion repeats, each has to span two of its overtones, or it may be anything that moves as one of them.
    """
    time, period = gap.chain.time, gap.blocks.period
    slowest = max(SLOWEST, FEWEST_TURNS / float(time[-1] - time[0]))
    fastest = min(FASTEST, IN_BAND * gap.chain.band)
    tried = []
    for ratio in DAMPING_RATIOS if fastest > slowest else ():
        count = int(np.ceil(np.log(fastest / slowest) / (APART * ratio)))
        for frequency in np.geomspace(slowest, fastest, count):
            if period is None or 2.0 * ratio * frequency * period > FEWEST_LINES:
                tried.append(Swing(joint, float(frequency), ratio))
    return tried


def courses(gap: Gap, tried: list[Swing]) -> Floats:
    """Return the courses of swings of one joint at the rows, in units of their RMS, (rows, swings).

    Each is at rest wherever a stretch of rows begins.  That the rows are filtered matters not: the acceleration is too,
    and what follows it linearly takes the same filter.
    """
    time, acceleration = gap.chain.time, covariate_rows(gap, tried[0].joint, "acceleration")
    step = float(np.median(np.diff(time)))
    starts = [0, *(np.flatnonzero(np.diff(time) > 1.5 * step) + 1).tolist(), time.size]
    out = np.empty((time.size, len(tried)))
    for k, swing in enumerate(tried):
        pole = 2.0 * np.pi * swing.frequency * complex(-swing.damping_ratio, 1.0)
        turn = np.exp(pole * step)
        # Exact where the acceleration goes straight from row to row.
        now = (turn - 1.0 - pole * step) / (pole**2 * step)
        before = (1.0 - turn + turn * pole * step) / (pole**2 * step)
        for first, past in itertools.pairwise(starts):
            own = acceleration[first:past].astype(complex)
            out[first:past, k] = -lfilter([now, before], [1.0, -turn], own, zi=[-now * own[0]])[0].imag
    out /= np.maximum(np.sqrt(np.mean(np.square(out), axis=0)), 1e-300)
    return out
