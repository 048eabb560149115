"""A steady tone in what is left at a joint: a torque periodic in time, at a frequency at which nothing moves."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize_scalar

from mjfriction.identify.gap import Gap
from mjfriction.record.log import Floats

FEWEST_TURNS = 10.0  # of a tone, that the rows must hold
FINER = 4  # lines that are looked at for one that the length of the log can tell apart
MOST_GAPS = 20  # times the rows, that a log may last
MOVING = 0.2  # share of a joint's velocity at the frequency, from which on it may be the motion's own


@dataclass(frozen=True)
class Tone:
    """A tone of ``frequency`` (Hz) that makes up a ``share`` of what is left where friction is clear, 0 to 1."""

    frequency: float
    share: float

    @property
    def words(self) -> str:
        """The tone as a person says it."""
        return f"a steady tone of {self.frequency:.3g} Hz"


def steady_tone(gap: Gap, joint: int, residual: Floats) -> Tone | None:
    """Return the strongest tone of a joint's residual (rows,): of all A·cos 2πft + B·sin 2πft + C, the one that leaves
    least.

    None where some joint moves at its frequency: it may then be anything that the motion brings about.  None, too,
    where the log is mostly gaps.
    """
    time, clear = gap.chain.time, gap.clear[:, joint]
    step = float(np.median(np.diff(time)))
    place = np.rint((time - time[0]) / step).astype(np.int64)
    if place[-1] > MOST_GAPS * time.size:
        return None
    course = np.zeros(int(place[-1]) + 1)
    course[place[clear]] = residual[clear] - np.mean(residual[clear])
    power = np.abs(np.fft.rfft(course * np.hanning(course.size), FINER * course.size))
    frequency = np.fft.rfftfreq(FINER * course.size, step)
    slowest = FEWEST_TURNS / (course.size * step)
    if frequency[-1] <= slowest:
        return None
    strongest = float(frequency[np.argmax(np.where(frequency >= slowest, power, 0.0))])
    width = 1.0 / (course.size * step)
    found = minimize_scalar(
        lambda f: -_share(f, time[clear], residual[clear]),
        bounds=(strongest - width, strongest + width),
        method="bounded",
        options={"xatol": 1e-3 * width},
    )
    tone = Tone(float(found.x), -float(found.fun))
    moved = [_share(tone.frequency, time, velocity) for velocity in gap.at_rows("velocity").T]
    return None if max(moved) > MOVING else tone


def _share(frequency: float, time: Floats, course: Floats) -> float:
    # The share of a course's variance that the best tone of a frequency has.
    phase = 2.0 * np.pi * frequency * time
    columns = np.column_stack([np.cos(phase), np.sin(phase), np.ones_like(time)])
    left = course - columns @ np.linalg.lstsq(columns, course, rcond=None)[0]
    return float(1.0 - np.var(left) / max(float(np.var(course)), 1e-300))
