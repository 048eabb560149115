"""What a model gains on held-out motion."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mjfriction.identify.gap import Gap
from mjfriction.record.log import Floats, Integers

BOOTSTRAPS = 2000


@dataclass(frozen=True)
class Gain:
    """Held-out RMS error at a joint without and with a cause, of effort unless something else is stated.

    ``reduction`` = 1 − after/before; ``low`` and ``high`` are its 95 % bounds.
    """

    before: float
    after: float
    reduction: float
    low: float
    high: float


def measure_gain(before: Floats, after: Floats, block: Integers, seed: int) -> Gain:
    """Compare two residuals of one joint, each (rows,), with an interval from resampling whole blocks of motion."""
    block = np.unique(block, return_inverse=True)[1]  # some blocks may have no rows at all
    count = int(np.max(block)) + 1
    size = np.bincount(block, minlength=count)
    sums = np.stack([np.bincount(block, np.square(values), minlength=count) for values in (before, after)])
    rms = np.sqrt(sums.sum(axis=1) / block.size)
    draws = np.random.default_rng(seed).integers(0, count, (BOOTSTRAPS, count))
    resampled = np.sqrt(sums[:, draws].sum(axis=2) / size[draws].sum(axis=1))
    reduction = 1.0 - resampled[1] / np.maximum(resampled[0], 1e-300)
    low, high = np.quantile(reduction, [0.025, 0.975])
    return Gain(float(rms[0]), float(rms[1]), float(1.0 - rms[1] / max(rms[0], 1e-300)), float(low), float(high))


def gain_at(gap: Gap, before: Floats, after: Floats, joint: int, seed: int) -> Gain:
    """Compare two held-out residuals (rows, joints) at a joint, in the unit its drive reports, on its clear rows."""
    clear, unit = gap.clear[:, joint], abs(float(gap.per_reported[joint]))
    return measure_gain(before[clear, joint] / unit, after[clear, joint] / unit, gap.blocks.row[clear], seed)
