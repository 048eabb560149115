"""The highest frequencies that a log's efforts still contain: some drives report them strongly low-passed.

Dry friction changes sign with every reversal, and steps have power at all frequencies, falling with 1/f².  Where an
effort contains far less than that, a filter has removed it.  Compared with a prediction with sharp reversals, it would
look like friction that builds up slowly.
"""

from __future__ import annotations

import itertools

import numpy as np
from scipy.signal import welch

from mjfriction.identify.doubt import doubt_speeds
from mjfriction.record.log import Floats
from mjfriction.record.motion import Motion
from mjfriction.robot.effort import Effort

GONE = 0.03  # share of the steps' power, below which a filter has removed the rest
FEWEST_STEPS = 0.01  # share of the effort's RMS that dry friction must reach for this test
SECONDS = 8.0  # s, window of the spectrum
LOWEST, HIGHEST = 0.5, 0.4  # Hz, and share of the rate: the range that is examined
BANDS_PER_OCTAVE = 3
PASSES = 0.8  # of the frequency at which the power is gone: up to there it is still complete


def whole_below(filtered: Floats) -> float:
    """Return the frequency (Hz) up to which every joint's effort is complete.

    ``filtered`` are the frequencies from which on each joint's effort is not.
    """
    return PASSES * float(np.min(filtered))


def filtered_from(motion: Motion, effort: Effort, measured: Floats) -> Floats:
    """Return the frequencies (Hz) above which efforts have lost their steps, (joints,), infinite where none shows.

    ``measured`` (n, joints) is the effort that the drives reported, NaN where a joint has none.
    """
    out, slow = np.full(measured.shape[1], np.inf), doubt_speeds(motion)
    for i in range(measured.shape[1]):
        if np.isfinite(measured[0, i]) and motion.moving[i]:
            out[i] = _filtered_from(motion, effort, measured[:, i], i, _sure_course(motion, i, float(slow[i])))
    return out


def _sure_course(motion: Motion, joint: int, slow: float) -> Floats:
    # The direction of friction where a joint surely moves, changing linearly in between.  A joint at rest holds what
    # its drive gives, which may change sign slowly, whichever way the sensor's noise points.
    velocity, out = motion.velocity[:, joint], np.zeros(motion.time.size)
    for own in motion.pieces:
        time, speed = motion.time[own], velocity[own]
        sure = np.abs(speed) > slow
        if np.any(sure):
            out[own] = np.interp(time, time[sure], np.sign(speed[sure]))
    return out


def _filtered_from(motion: Motion, effort: Effort, measured: Floats, joint: int, forward: Floats) -> float:
    columns = np.column_stack([forward, motion.velocity[:, joint], effort.rigid[:, joint], np.ones_like(forward)])
    level = abs(float(np.linalg.lstsq(columns, measured, rcond=None)[0][0]))
    size = float(np.std(measured))
    if level < FEWEST_STEPS * size:
        return float("inf")
    count = min(measured.size, int(SECONDS * motion.rate))
    frequency, steps = welch(level * forward, motion.rate, nperseg=count)
    _, power = welch(measured, motion.rate, nperseg=count)
    edges = np.exp2(np.arange(np.log2(LOWEST), np.log2(HIGHEST * motion.rate), 1.0 / BANDS_PER_OCTAVE))
    gone = []
    for low, high in itertools.pairwise(edges):
        inside = (frequency >= low) & (frequency < high)
        gone.append(bool(np.any(inside) and np.sum(power[inside]) < GONE * np.sum(steps[inside])))
    for k in range(len(gone) - BANDS_PER_OCTAVE + 1):
        if all(gone[k : k + BANDS_PER_OCTAVE]):
            return float(edges[k])
    return float("inf")
