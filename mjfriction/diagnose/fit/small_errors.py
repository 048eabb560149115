"""The many small errors that every model of a machine has, and what stands out of them."""

from __future__ import annotations

import math

from mjfriction.identify.gap import Gap
from mjfriction.record.log import Floats

NOISY = 2.5  # multiple of the sensor's noise up to which what is left at a joint may be noise
STANDS_OUT = 0.75  # share of the mean square beyond that which a cause must remove to be more than one small error
USUAL = 0.02  # of a joint's RMS effort: as large as one small error may be


def least_to_stand_out(gap: Gap, joint: int, left: Floats) -> float:
    """Return the RMS effort (N·m, N) that a cause must remove at a joint beside what is ``left`` there (rows,).

    What is left far above the sensor's noise is ripple, cables that pull, joints that give, links that are a percent
    off: each shows, and none is what the model lacks.  A cause must remove nearly as much as they leave together.  One
    that is no larger than a usual one of them must stand out more: the mean square that it removes must also exceed the
    geometric mean of what is left and of a usual one.
    """
    noise, usual = NOISY * float(gap.noise_floor[joint]), USUAL * gap.rms(gap.measured[:, joint], joint)
    small = math.sqrt(STANDS_OUT * max(0.0, gap.rms(left, joint) ** 2 - noise**2))
    return max(small, math.sqrt(small * usual))


def stands_out(gap: Gap, joint: int, without: Floats, beside: Floats) -> bool:
    """Return whether a change of a model removes more at a joint than the small errors that it leaves there.

    ``without`` and ``beside`` are the residuals (rows, joints) without and with the change.
    """
    return removed(gap, joint, without, beside) > least_to_stand_out(gap, joint, beside[:, joint]) ** 2


def noise_alone(gap: Gap, left: Floats) -> bool:
    """Return whether what is ``left`` (rows, joints) at every joint may be the sensor's noise: no small errors show."""
    return all(as_noise(gap, joint, gap.rms(left[:, joint], joint)) for joint in gap.examined)


def as_noise(gap: Gap, joint: int, rms: float) -> bool:
    """Return whether an ``rms`` (N·m, N) that is left at a joint may be its sensor's noise."""
    return bool(rms <= NOISY * gap.noise_floor[joint])


def removed(gap: Gap, joint: int, without: Floats, beside: Floats) -> float:
    """Return the mean square ((N·m)², N²) that a change of a model removes at a joint; arguments as above."""
    before, after = (gap.rms(left[:, joint], joint) ** 2 for left in (without, beside))
    return before - after
