"""How much a signal chatters: its content at frequencies above those of the machine's motion."""

from __future__ import annotations

import numpy as np
from scipy.signal import welch

from mjfriction.errors import ControlError
from mjfriction.laws.law import Floats

PIECE = 2.0  # s, length of the segments of Welch's method


def spectrum(values: Floats, rate: float) -> tuple[Floats, Floats]:
    """Return frequencies (Hz) and power density (unit²/Hz) of a signal (n,), by Welch's method with 2 s segments."""
    frequency, power = welch(values, fs=rate, nperseg=min(values.size, round(PIECE * rate)))
    return np.asarray(frequency), np.asarray(power)


def chattering(values: Floats, rate: float, above: float) -> float:
    """Return the RMS of a signal's (n,) content above a frequency (Hz), in the signal's unit.

    Raises :class:`ControlError` for a frequency that is not between 0 and half of the sampling ``rate`` (Hz).
    """
    if not 0.0 < above < 0.5 * rate:
        raise ControlError(f"chattering above {above:g} Hz cannot be seen at {rate:g} Hz; stay below {0.5 * rate:g} Hz")
    frequency, power = spectrum(values, rate)
    fast = frequency >= above
    return float(np.sqrt(np.sum(power[fast]) * (frequency[1] - frequency[0])))
