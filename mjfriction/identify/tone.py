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
MOVING = 0.2  # share of a joint's course at the frequency, from which on it may be the motion's own
ON_LINE = 0.25  # of what the length of the log can tell apart, within which a tone may be the motion's overtone


@dataclass(frozen=True)
class Tone:
    """A tone of ``frequency`` (Hz) at a ``joint``."""

    joint: int
    frequency: float

    @property
    def words(self) -> str:
        """What it is, in words."""
        return f"a steady tone of {self.frequency:.3g} Hz"

    def columns(self, gap: Gap) -> Floats:
        """Return its cosine and its sine at the rows, (rows, 2)."""
        return waves(self.frequency, gap.chain.time)


def waves(frequency: float, time: Floats) -> Floats:
    """Return the cosine and the sine of a frequency (Hz) at times (rows,), s: (rows, 2)."""
    phase = 2.0 * np.pi * frequency * time
    return np.column_stack([np.cos(phase), np.sin(phase)])


def steady_tone(gap: Gap, joint: int, residual: Floats) -> tuple[Tone, float] | None:
    """Return the strongest tone of a joint's residual (rows,): of all A·cos 2πft + B·sin 2πft + C, the one that leaves
    least; with it, its share of what is left there where friction is clear, 0 to 1.

    None where some joint moves at its frequency, or at half of it, or where it is an overtone of motion that repeats:
    it may then be anything that the motion brings about.  None, too, where the log is mostly gaps.
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
    slowest = FEWEST_TURNS / (time.size * step)
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
    tone = Tone(joint, float(found.x))
    return None if _of_motion(gap, tone.frequency) else (tone, -float(found.fun))


def _of_motion(gap: Gap, frequency: float) -> bool:
    time, period = gap.chain.time, gap.blocks.period
    velocity, position = gap.at_rows("velocity"), gap.at_rows("position")
    # What is the same either way of a swing comes twice as often.
    courses = [velocity, np.abs(velocity), np.square(position - np.mean(position, axis=0))]
    if max(_share(frequency, time, course) for own in courses for course in own.T) > MOVING:
        return True
    turns = 0.0 if period is None else frequency * period
    return period is not None and abs(turns - round(turns)) * (time[-1] - time[0]) < ON_LINE * period


def _share(frequency: float, time: Floats, course: Floats) -> float:
    # The share of a course's variance that the best tone of a frequency has.
    columns = np.column_stack([waves(frequency, time), np.ones_like(time)])
    left = course - columns @ np.linalg.lstsq(columns, course, rcond=None)[0]
    return float(1.0 - np.var(left) / max(float(np.var(course)), 1e-300))
