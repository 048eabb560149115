"""The noise level of a sampled signal, estimated from the signal alone."""

from __future__ import annotations

import math

import numpy as np

from mjfriction.record.log import Floats, Log
from mjfriction.record.resample import Clock, even_grid, onto_grid

ORDER = 8  # differences of this order keep the noise and almost nothing of a well-sampled motion
TRIMMED = 0.01  # share of the largest differences left out: jumps at reversals and single-sample glitches


def noise_level(pieces: list[Floats]) -> float:
    """Return the standard deviation of the white part of a signal.

    The differences of order p of white noise have the variance C(2p, p)·σ².  A motion of frequency f sampled at rate r
    keeps (2πf/r)^p of its amplitude, so that p = 8 separates the two wherever the sampling is adequate.  ``pieces`` are
    evenly sampled stretches, each of shape (n,).
    """
    differences = [np.diff(piece, n=ORDER) for piece in pieces if piece.size > 2 * ORDER]
    if not differences:
        return 0.0
    squares = np.sort(np.square(np.concatenate(differences)))
    kept = squares[: max(1, int(squares.size * (1.0 - TRIMMED)))]
    # The mean of the squares of a standard normal variable, without the contribution of the largest 1 %.
    correction = 1.0 - 2.0 * _trimmed_share()
    return math.sqrt(float(np.mean(kept)) * (1.0 - TRIMMED) / (correction * math.comb(2 * ORDER, ORDER)))


def raw_noise(log: Log, quantity: str, joint: str, clock: Clock) -> float:
    """Return the white-noise level of one recorded column, 0 where it was not recorded."""
    values = log.channel(quantity, joint)
    if values is None:
        return 0.0
    grids = [even_grid(log, clock, piece) for piece in clock.pieces]
    return noise_level([onto_grid(values, log.time, grid, smooth=True) for grid in grids])


def _trimmed_share() -> float:
    # ∫_{a}^∞ x² φ(x) dx with P(|x| > a) = TRIMMED.
    edge = 2.5758293035489004
    density = math.exp(-0.5 * edge * edge) / math.sqrt(2.0 * math.pi)
    return edge * density + 0.5 * TRIMMED
