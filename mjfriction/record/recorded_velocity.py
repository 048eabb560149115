"""A joint's measured velocity, held against its position: whether it is that position's, when, and tells more."""

from __future__ import annotations

import numpy as np
from scipy.signal import coherence, welch

from mjfriction.errors import LogError
from mjfriction.record.log import POSITION, VELOCITY, Floats, Log
from mjfriction.record.low_pass import ORDER, butterworth
from mjfriction.record.noise import raw_noise
from mjfriction.record.resample import Clock, long_grids, onto_grid, read_clock

AGREEMENT = 0.03  # measured velocity is believed when its gain is within this of the derivative of position
LIKENESS = 0.95  # correlation from which on a measured velocity is that of its position, whatever its unit or clock
LATEST = 0.1  # periods of the cutoff by which it may come late, as a drive's does that is filtered
SLOWLY = 0.1  # of the cutoff, below which both are compared
# Hz, and of the rate, up to which from half of it on noise is looked for: above what arms do, and below what a drive's
# low-pass leaves nothing of.
QUICKLY, MOST_QUICKLY = 80.0, 0.4
SPELL = 0.5  # s, of which coherence is averaged
NOISE_ALONE = 3.0  # times what noise alone makes, that may be there for it to be noise
COHERENT = 0.5  # of a velocity's power there, that goes with its position's


def velocity_lateness(log: Log, joint: str, cutoff: float, clock: Clock) -> float | None:
    """Return by how much (s) a joint's measured velocity comes after its position's: most drives filter theirs.

    None where it is not the position's: another in gain, or in time by more than a low-pass of that ``cutoff`` (Hz)
    allows; or where it is made of that position, noise and all, so that it tells nothing more, however smooth it is.
    Both are compared slowly: where noise makes most of the acceleration, a velocity that comes late looks like none.
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
    """Return what a joint's measured velocity reads over what its position does on the log's clock, slowly, well below
    ``cutoff`` (Hz); None where they are not alike at all, there is no such column, or the clock is none.
    """
    if log.channel(VELOCITY, joint) is None:
        return None
    try:
        clock = read_clock(log)
    except LogError:
        return None  # a few rows, or uneven ones, of a log that as a whole is none such
    compared = _compared_slowly(log, joint, cutoff, clock)
    if compared is None:
        return None
    own, _, other = compared
    power, cross, mine = (float(np.mean(pair)) for pair in (other * other, other * own, own * own))
    return cross / power if power > 0.0 and cross > LIKENESS * np.sqrt(power * mine) else None


def _made_of_it(log: Log, joint: str, clock: Clock) -> bool:
    # Whether a joint's velocity goes with its position at frequencies where that is nothing but noise.  (Differences
    # of both, or the motion far below would leak into them.)
    position, velocity = log.channel(POSITION, joint), log.channel(VELOCITY, joint)
    if position is None or velocity is None:
        return False
    grid = max(long_grids(log, clock), key=lambda one: one.time.size)
    own = np.diff(onto_grid(position, log.time, grid, smooth=True), 2)
    other = np.diff(onto_grid(velocity, log.time, grid, smooth=True), 1)[1:]
    rate = 1.0 / clock.step
    spell = {"fs": rate, "nperseg": max(16, int(SPELL * rate))}
    if own.size < 4 * spell["nperseg"] or not (np.any(own) and np.any(other)):
        return False
    frequency, power = welch(own, **spell)
    highest = min(QUICKLY, MOST_QUICKLY * rate)
    band = (frequency >= 0.5 * highest) & (frequency <= highest)
    noise = 2.0 * raw_noise(log, POSITION, joint, clock) ** 2 / rate * (2.0 * np.sin(np.pi * frequency / rate)) ** 4
    if np.sum(power[band]) > NOISE_ALONE * np.sum(noise[band]):
        return False
    return bool(np.mean(coherence(own, other, **spell)[1][band]) > COHERENT)


def _compared_slowly(log: Log, joint: str, cutoff: float, clock: Clock) -> tuple[Floats, Floats, Floats] | None:
    # A joint's measured velocity, its rate of change, and the rate of change of its position, all low-passed alike.
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
    # What the filter's ends touch is left out.
    edge = int(rate / (SLOWLY * cutoff))
    inner = [slice(edge, piece.size - edge) if piece.size > 4 * edge else slice(None) for piece in smooth[0]]
    own = np.concatenate([piece[part] for piece, part in zip(smooth[1], inner, strict=True)])
    change = np.concatenate([(np.gradient(piece) * rate)[part] for piece, part in zip(smooth[1], inner, strict=True)])
    other = np.concatenate([(np.gradient(piece) * rate)[part] for piece, part in zip(smooth[0], inner, strict=True)])
    return own, change, other
