"""A low-pass that shifts nothing in time."""

from __future__ import annotations

import functools
from dataclasses import dataclass

import numpy as np
from scipy.signal import butter, sosfilt, sosfilt_zi, sosfiltfilt

from mjfriction.record.log import Floats

ORDER = 4  # of the Butterworth, which goes over the values twice: forward and backward
EDGE_PERIODS = 2.0  # of the band, by which values are continued at their ends
HIGHEST = 0.4  # of the rate


@dataclass(frozen=True)
class LowPass:
    """A Butterworth's sections (k, 6), and their state (k, 2) when they have seen nothing but 1 for ever."""

    sections: Floats
    settled: Floats

    def to_and_fro(self, values: Floats) -> Floats:
        """Return values (n,) through it forward and backward, as if they began and ended with a rest: what SciPy's
        ``sosfiltfilt`` without padding does, but that works out the state anew at every call.
        """
        forward, _ = sosfilt(self.sections, values, zi=self.settled * values[0])
        backward, _ = sosfilt(self.sections, forward[::-1], zi=self.settled * forward[-1])
        return np.asarray(backward[::-1])


@functools.lru_cache(maxsize=64)
def butterworth(order: int, band: float, rate: float) -> LowPass:
    """Return the Butterworth low-pass at ``band`` (Hz) for samples at a ``rate`` (Hz)."""
    sections = np.asarray(butter(order, band, fs=rate, output="sos"))
    return LowPass(sections, np.asarray(sosfilt_zi(sections)))


def low_passed(values: Floats, rate: float, band: float) -> Floats:
    """Return values (n, …) sampled at a rate (Hz) through a fourth-order Butterworth at ``band`` (Hz) to and fro.

    Its gain is 1/2 at the band.
    """
    slow = butterworth(ORDER, min(band, HIGHEST * rate), rate)
    edge = min(values.shape[0] - 1, int(EDGE_PERIODS * rate / band))
    return np.asarray(sosfiltfilt(slow.sections, values, axis=0, padlen=edge))
