"""A low-pass that shifts nothing in time."""

from __future__ import annotations

import functools

import numpy as np
from scipy.signal import butter, sosfiltfilt

from mjfriction.record.log import Floats

ORDER = 4  # of the Butterworth, which goes over the values twice: forward and backward
EDGE_PERIODS = 2.0  # of the band, by which values are continued at their ends
HIGHEST = 0.4  # of the rate


@functools.lru_cache(maxsize=64)
def butterworth(order: int, band: float, rate: float) -> Floats:
    """Return the sections (k, 6) of a Butterworth low-pass at ``band`` (Hz) for samples at a ``rate`` (Hz).

    They are kept, and may not be written to.
    """
    return np.asarray(butter(order, band, fs=rate, output="sos"))


def low_passed(values: Floats, rate: float, band: float) -> Floats:
    """Return values (n, …) sampled at a rate (Hz) through a fourth-order Butterworth at ``band`` (Hz) to and fro.

    Its gain is 1/2 at the band.
    """
    sos = butterworth(ORDER, min(band, HIGHEST * rate), rate)
    edge = min(values.shape[0] - 1, int(EDGE_PERIODS * rate / band))
    return np.asarray(sosfiltfilt(sos, values, axis=0, padlen=edge))
