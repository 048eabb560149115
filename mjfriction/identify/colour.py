"""How much of a residual is not noise, whatever it follows: what stands above the noise in its spectrum."""

from __future__ import annotations

import numpy as np

from mjfriction.identify.gap import Gap
from mjfriction.record.log import Floats

NOTHING = "nothing that is known"  # named where a residual is not noise but follows no covariate
COLOURED = 0.5  # share of the residual that may stand above the noise in its spectrum before it counts
BINS = 60  # of the spectrum, even in frequency
EVEN_BELOW = 6.0  # Hz, below which no drive's filter shapes its noise
AROUND = 2.0  # factor above and below a frequency within which noise is taken to be even
FASTEST = 1.0 / 3.0  # fastest share of the spectrum, whose level no slow course raises
STANDS_OUT = 4.0  # deviations by which a bin must exceed the noise's level
SLOWEST = 2  # lowest lines of the spectrum, left out: they hold the mean and the window's leakage of it
WINDOW_LOSS = 1.5  # lines of a Hann window's spectrum that count as one independent line
FEWEST_ALIKE = 3  # other joints of whose noise a colour can be told
MOST_ALIKE = 3.0  # multiple of the sensor's noise up to which all joints alike may show noise; nothing as slow is noise


def coloured_share(gap: Gap, joint: int, residuals: Floats) -> float:
    """Return the share of a joint's residual that stands above the noise in its spectrum, 0 to 1.

    The rows are so thin that white noise stays white.  Its level is that of the effort sensor, of the spectrum's
    fastest third, or of an octave to either side, whichever is highest.  A drive's own filter removes the fastest part
    of its noise, from some ten Hz on, and leaves it even below.  What stands clearly above that level is a course and
    not noise: a drift, a hum, a swing.  White noise gives 0.  So does low-passed noise, and noise that grows with
    frequency, such as that of differentiated positions.

    ``residuals`` (rows, joints) are those of all joints.  What most other joints show alike, relative to their sensors'
    noise, is the colour of that noise: the same amplifiers, filters and clocks are behind all of them.
    """
    if not np.any(gap.clear[:, joint]):
        return 0.0
    power, sensor = _spectrum(gap, joint, residuals)
    width = max(1, power.size // BINS)
    bins, frequency = (_binned(values, width) for values in (power, _frequencies(gap, residuals.shape[0])))
    fastest = float(np.mean(power[-int(FASTEST * power.size) :]))
    level = np.maximum(max(fastest, sensor), _around(bins, frequency))
    level = np.maximum(level, sensor * _of_others(gap, joint, residuals, width))
    above = np.where(bins > level * (1.0 + STANDS_OUT * np.sqrt(WINDOW_LOSS / width)), bins - level, 0.0)
    return float(np.sum(above) / max(float(np.sum(bins)), 1e-300))


def _spectrum(gap: Gap, joint: int, residuals: Floats) -> tuple[Floats, float]:
    # The power of a joint's residual by frequency, and that of its sensor's noise.
    clear = gap.clear[:, joint]
    window = np.where(clear, np.hanning(clear.size), 0.0)
    power = np.square(np.abs(np.fft.rfft(window * np.where(clear, residuals[:, joint], 0.0))))[SLOWEST:]
    return power, float(gap.noise_floor[joint] ** 2 * np.sum(np.square(window)))


def _of_others(gap: Gap, joint: int, residuals: Floats, width: int) -> Floats:
    # The median over the other joints of their binned power, relative to that of their sensors' noise.
    spectra = [_spectrum(gap, other, residuals) for other in gap.examined if other != joint]
    known = [_binned(power, width) / sensor for power, sensor in spectra if sensor > 0.0]
    if len(known) < FEWEST_ALIKE:
        return np.zeros(1)
    alike = np.median(known, axis=0)
    return np.asarray(alike * min(1.0, MOST_ALIKE**2 / max(float(np.mean(alike)), 1e-300)))


def _frequencies(gap: Gap, rows: int) -> Floats:
    return np.asarray(np.fft.rfftfreq(rows, gap.chain.step)[SLOWEST:])


def _binned(values: Floats, width: int) -> Floats:
    return np.asarray(values[: values.size // width * width].reshape(-1, width).mean(axis=1))


def _around(bins: Floats, frequency: Floats) -> Floats:
    # The median of the bins within an octave of each, from the frequency on at which noise is even.
    middle = np.maximum(frequency, min(EVEN_BELOW, float(frequency[-1])))
    near = np.abs(np.log(frequency[None, :] / middle[:, None])) <= np.log(AROUND)
    return np.array([np.median(bins[own]) for own in near])
