"""A joint's measured velocity against its position: whether they agree, its lag, and whether it adds information."""

from __future__ import annotations

import numpy as np
from scipy.signal import stft

from mjfriction.errors import LogError
from mjfriction.record.log import POSITION, VELOCITY, Floats, Log
from mjfriction.record.low_pass import ORDER, butterworth
from mjfriction.record.noise import raw_noise
from mjfriction.record.resample import Clock, long_grids, onto_grid, read_clock

AGREEMENT = 0.03  # a measured velocity is used only if its gain deviates less than this from the derivative of position
LIKENESS = 0.95  # correlation beyond which a measured velocity belongs to its position, whatever its unit or clock
LATEST = 0.1  # periods of the cutoff; longest lag that is accepted, such as a drive's low-pass causes
SLOWLY = 0.1  # of the cutoff; both are low-passed there to be compared
# Upper end of the band in which noise is examined, Hz and share of the sampling rate; it begins at half of that.  The
# band is above an arm's motion, and below the frequencies that a drive's low-pass removes.
QUICKLY, MOST_QUICKLY = 80.0, 0.4
SPELL = 0.5  # s, length of the windows over which coherence is averaged
NOISE_ALONE = 3.0  # times the noise's power; a position with more power in the band than this also moves there
COHERENT = 0.5  # mean coherence in the band beyond which a velocity is computed from its position


def velocity_lateness(log: Log, joint: str, cutoff: float, clock: Clock) -> float | None:
    """Return how far (s) a joint's measured velocity lags behind its position's derivative: most drives filter theirs.

    None where the two do not agree: in gain, or in time by more than LATEST periods of the ``cutoff`` (Hz).  None also
    where the velocity is computed from that position, noise included, and so adds no information, however smooth it is.
    Both are compared at low frequencies: where noise dominates the acceleration, a velocity that lags seems not to
    agree at all.
    """
    compared = _compared_slowly(log, joint, cutoff, clock)
    if compared is None or _made_of_it(log, joint, clock):
        return None
    own, change, other = compared
    difference = other - own
    gain = np.mean(difference * own) / max(float(np.mean(np.square(own))), 1e-300)
    late = np.mean(difference * change) / max(float(np.mean(np.square(change))), 1e-300)
    return float(late) if abs(gain) < AGREEMENT and abs(late) < LATEST / cutoff else None


def velocity_ratio(log: Log, joint: str, cutoff: float) -> float | None:
    """Return a joint's measured velocity over the derivative of its position by the log's clock, at low frequencies,
    well below ``cutoff`` (Hz); negative where one of the two has its sign reversed.

    None where the two are not correlated, the log has no such column, or its clock cannot be used.
    """
    if log.channel(VELOCITY, joint) is None:
        return None
    try:
        clock = read_clock(log)
    except LogError:
        return None  # a part of a log may have too few or too uneven rows, even if the whole log has not
    compared = _compared_slowly(log, joint, cutoff, clock)
    if compared is None:
        return None
    own, _, other = compared
    power, cross, mine = (float(np.mean(pair)) for pair in (other * other, other * own, own * own))
    return cross / power if power > 0.0 and abs(cross) > LIKENESS * np.sqrt(power * mine) else None


def _made_of_it(log: Log, joint: str, clock: Clock) -> bool:
    # Whether a joint's velocity is coherent with its position at frequencies where the position is only noise.  Both
    # are differenced, or the motion at far lower frequencies would leak into the band.
    position, velocity = log.channel(POSITION, joint), log.channel(VELOCITY, joint)
    if position is None or velocity is None:
        return False
    grid = max(long_grids(log, clock), key=lambda one: one.time.size)
    own = np.diff(onto_grid(position, log.time, grid, smooth=True), 2)
    other = np.diff(onto_grid(velocity, log.time, grid, smooth=True), 1)[1:]
    rate = 1.0 / clock.step
    spell = max(16, int(SPELL * rate))
    if own.size < 4 * spell or not (np.any(own) and np.any(other)):
        return False
    # Welch's method; its own function goes from window to window in Python, and a log has hundreds.
    frequency, _, (mine, its) = stft(
        np.stack([own, other]), rate, nperseg=spell, detrend="constant", boundary=None, padded=False, scaling="psd"
    )
    power, its_power = (2.0 * np.mean(np.square(np.abs(spectrum)), axis=1) for spectrum in (mine, its))
    cross = 2.0 * np.mean(np.conj(mine) * its, axis=1)
    highest = min(QUICKLY, MOST_QUICKLY * rate)
    band = (frequency >= 0.5 * highest) & (frequency <= highest)
    noise = 2.0 * raw_noise(log, POSITION, joint, clock) ** 2 / rate * (2.0 * np.sin(np.pi * frequency / rate)) ** 4
    if np.sum(power[band]) > NOISE_ALONE * np.sum(noise[band]):
        return False
    coherence = np.square(np.abs(cross[band])) / (power[band] * its_power[band])
    return bool(np.mean(coherence) > COHERENT)


def _compared_slowly(log: Log, joint: str, cutoff: float, clock: Clock) -> tuple[Floats, Floats, Floats] | None:
    # A joint's measured velocity, its rate of change, and the rate of change of its position, all low-passed equally.
    position, velocity = log.channel(POSITION, joint), log.channel(VELOCITY, joint)
    grids = long_grids(log, clock)
    if position is None or velocity is None or not grids:
        return None
    rate = 1.0 / clock.step
    slow = butterworth(ORDER, SLOWLY * min(cutoff, 0.45 * rate), rate)
    smooth = [
        [slow.to_and_fro(onto_grid(values, log.time, grid, smooth=True)) for grid in grids]
        for values in (position, velocity)
    ]
    # Samples near the ends, which the filter affects, are left out.
    edge = int(rate / (SLOWLY * cutoff))
    inner = [slice(edge, piece.size - edge) if piece.size > 4 * edge else slice(None) for piece in smooth[0]]
    own = np.concatenate([piece[part] for piece, part in zip(smooth[1], inner, strict=True)])
    change = np.concatenate([(np.gradient(piece) * rate)[part] for piece, part in zip(smooth[1], inner, strict=True)])
    other = np.concatenate([(np.gradient(piece) * rate)[part] for piece, part in zip(smooth[0], inner, strict=True)])
    return own, change, other
