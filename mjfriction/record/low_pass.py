"""A zero-phase low-pass: it shifts nothing in time."""

from __future__ import annotations

import functools
from dataclasses import dataclass

import numpy as np
from scipy.signal import butter, sosfilt, sosfilt_zi, sosfiltfilt

from mjfriction.record.log import Floats

ORDER = 4  # of the Butterworth filter, which is applied twice: forward and backward
EDGE_PERIODS = 2.0  # padding at both ends, in periods of the band
HIGHEST = 0.4  # of the sampling rate, the highest band


@dataclass(frozen=True)
class LowPass:
    """A Butterworth filter's second-order sections (k, 6), and their steady state (k, 2) for a constant input of 1."""

    sections: Floats
    settled: Floats

    def to_and_fro(self, values: Floats) -> Floats:
        """Return values (n,) filtered forward and backward, as if they were constant before the start and past the end.

        SciPy's ``sosfiltfilt`` without padding does the same, but computes the steady state anew at every call.
        """
        forward, _ = sosfilt(self.sections, values, zi=self.settled * values[0])
        backward, _ = sosfilt(self.sections, forward[::-1], zi=self.settled * forward[-1])
        return np.asarray(backward[::-1])


@functools.lru_cache(maxsize=64)
def butterworth(order: int, band: float, rate: float) -> LowPass:
    """Return the Butterworth low-pass with cutoff ``band`` (Hz) for samples at a ``rate`` (Hz)."""
    sections = np.asarray(butter(order, band, fs=rate, output="sos"))
    return LowPass(sections, np.asarray(sosfilt_zi(sections)))


def low_passed(values: Floats, rate: float, band: float) -> Floats:
    """Return values (n, …), sampled at a rate (Hz), filtered forward and backward by a fourth-order Butterworth filter.

    The gain is 1/2 at the ``band`` (Hz).
    """
    slow = butterworth(ORDER, min(band, HIGHEST * rate), rate)
    edge = min(values.shape[0] - 1, int(EDGE_PERIODS * rate / band))
    return np.asarray(sosfiltfilt(slow.sections, values, axis=0, padlen=edge))
