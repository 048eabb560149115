"""Turn samples into rows of a regression, in the same way for what was measured and for what is predicted.

Everything that enters the regression, the drives' effort and every regressor, passes through one low-pass without phase
lag and is thinned to its rate.  The same linear filter on both sides of a linear equation leaves its parameters
unchanged.  A sign change is blurred alike in data and model, and thinned white noise stays white.
"""

from __future__ import annotations

import functools
import itertools
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.signal import firwin, upfirdn

from mjfriction.errors import LogError
from mjfriction.record.log import Floats, Integers
from mjfriction.record.motion import Motion

BAND_SHARE = 0.5  # of the position filter's cutoff; the filter's gain there is still 0.996, so it adds hardly any bias
ROWS_PER_BAND = 2.0  # rows per second over the band's edge in Hz: as many as are independent under white noise
TAPS_PER_ROW = 8
MOST_ROWS = 1024  # rows of a part of a log that is processed at a time


@dataclass(frozen=True)
class Chain:
    """The filter and the samples that it turns into rows.

    ``spans`` are the settled stretches (first, past) of samples; ``time`` (rows,) is the centre of each row's window;
    ``band`` (Hz) is the edge of the low-pass; ``noise_gain`` is the share of white noise's standard deviation that
    passes.
    """

    taps: Floats
    thinning: int
    spans: tuple[tuple[int, int], ...]
    time: Floats
    piece: Integers
    band: float
    rate: float

    @property
    def step(self) -> float:
        """Seconds from row to row."""
        return self.thinning / self.rate

    @property
    def noise_gain(self) -> float:
        """Standard deviation of filtered unit white noise."""
        return float(np.sqrt(np.sum(np.square(self.taps))))

    def rows(self, samples: Floats) -> Floats:
        """Return samples (n,) or (n, k) as rows (rows,) or (rows, k)."""
        return self._through(self.taps, samples)

    def parts(self, motion: Motion, halo: int) -> Iterator[tuple[slice, Chain]]:
        """Return stretches of a motion's samples, each with the chain that makes its rows.

        Together they give all rows in order.  A stretch includes ``halo`` more samples on either side than its rows are
        made of, as far as its piece reaches.
        """
        first, row = -(-(self.taps.size - 1) // self.thinning), 0
        for start, past in self.spans:
            inside = np.flatnonzero(motion.piece == motion.piece[start])
            count = (past - start - 1) // self.thinning + 1
            for low in range(first, count, MOST_ROWS):
                high = min(low + MOST_ROWS, count)
                own = (start + (low - first) * self.thinning, start + (high - 1) * self.thinning + 1)
                begin, end = max(own[0] - halo, int(inside[0])), min(own[1] + halo, int(inside[-1]) + 1)
                rows = slice(row, row + high - low)
                span = (own[0] - begin, own[1] - begin)
                yield slice(begin, end), replace(self, spans=(span,), time=self.time[rows], piece=self.piece[rows])
                row += high - low

    def response(self, frequency: Floats) -> Floats:
        """Return the gain at given frequencies (Hz, any shape)."""
        return np.asarray(np.interp(np.abs(frequency) / self.rate, *self._gains))

    @functools.cached_property
    def _gains(self) -> tuple[Floats, Floats]:
        # Frequencies relative to the sampling rate, and the gain at each.
        grid, half = np.linspace(0.0, 0.5, 512), (self.taps.size - 1) // 2
        return grid, np.cos(2.0 * np.pi * np.outer(grid, np.arange(-half, half + 1))) @ self.taps

    def touched(self, mask: NDArray[np.bool_]) -> Floats:
        """Return the share of each row's window that a mask (n,) covers, from 0 to 1."""
        return self.averaged(mask.astype(np.float64))

    def averaged(self, sizes: Floats) -> Floats:
        """Return the mean of non-negative sizes (n,) over each row's window, (rows,)."""
        weight = np.abs(self.taps)
        return self._through(weight / np.sum(weight), sizes)

    def _through(self, taps: Floats, samples: Floats) -> Floats:
        first = -(-(taps.size - 1) // self.thinning)
        parts = []
        for start, past in self.spans:
            count = (past - start - 1) // self.thinning + 1
            parts.append(upfirdn(taps, samples[start:past], down=self.thinning, axis=0)[first:count])
        return np.concatenate(parts)


def make_chain(motion: Motion, source: str, highest: float = np.inf) -> Chain:
    """Return the chain for a motion, its band below ``highest`` (Hz).

    Raises :class:`LogError` when no stretch is long enough to give a row.
    """
    band = min(BAND_SHARE * motion.cutoff, highest)
    thinning = max(1, int(motion.rate / (ROWS_PER_BAND * band)))
    taps = firwin(2 * (TAPS_PER_ROW // 2) * thinning + 1, band, fs=motion.rate, window=("kaiser", 5.0))
    spans, centres = [], []
    change = np.flatnonzero(np.diff(motion.settled.astype(np.int8)) | np.diff(motion.piece)) + 1
    bounds = [0, *change.tolist(), motion.time.size]
    for start, past in itertools.pairwise(bounds):
        if motion.settled[start] and past - start > taps.size + thinning:
            first = -(-(taps.size - 1) // thinning)
            count = (past - start - 1) // thinning + 1
            spans.append((start, past))
            centres.append(start + np.arange(first, count) * thinning - (taps.size - 1) // 2)
    if not spans:
        raise LogError(
            f"{source}: no stretch between gaps and segment ends is longer than {taps.size + thinning} samples; "
            "record longer motions"
        )
    centre = np.concatenate(centres)
    return Chain(
        taps=taps,
        thinning=thinning,
        spans=tuple(spans),
        time=motion.time[centre],
        piece=motion.piece[centre],
        band=band,
        rate=motion.rate,
    )
