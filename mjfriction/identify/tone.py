"""A steady tone in a joint's residual: a torque periodic in time, at a frequency at which nothing moves."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize_scalar

from mjfriction.identify.gap import Gap
from mjfriction.record.log import Floats

FEWEST_TURNS = 10.0  # periods of a tone that the rows must contain
FINER = 4  # lines of the spectrum that are examined per line that the length of the log resolves
MOST_GAPS = 20  # times the rows, beyond which a log is mostly gaps
MOVING = 0.2  # share of a joint's course at the frequency, above which the tone may come from the motion
ON_LINE = 0.25  # share of the frequency resolution of the log, within which a tone may be an overtone of the motion


@dataclass(frozen=True)
class Tone:
    """A tone of ``frequency`` (Hz) at a ``joint``."""

    joint: int
    frequency: float

    @property
    def words(self) -> str:
        """A description in words."""
        return f"a steady tone of {self.frequency:.3g} Hz"

    def columns(self, gap: Gap) -> Floats:
        """Return the tone's cosine and sine at the rows, (rows, 2)."""
        return waves(self.frequency, gap.chain.time)


def waves(frequency: float, time: Floats) -> Floats:
    """Return the cosine and the sine of a frequency (Hz) at times (rows,), s: (rows, 2)."""
    phase = 2.0 * np.pi * frequency * time
    return np.column_stack([np.cos(phase), np.sin(phase)])


def steady_tone(gap: Gap, joint: int, residual: Floats) -> tuple[Tone, float] | None:
    """Return the strongest tone of a joint's ``residual`` (rows,), and its share of it where friction is clear, 0 to 1.

    Of all A·cos 2πft + B·sin 2πft + C it is the one that leaves least.

    None where some joint moves at the tone's frequency or at half of it, or where it is an overtone of motion that
    repeats: anything that the motion causes may then produce it.  None, too, where the log is mostly gaps.
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
    # What acts alike in both directions of a swing has twice the swing's frequency.
    courses = [velocity, np.abs(velocity), np.square(position - np.mean(position, axis=0))]
    if max(_share(frequency, time, course) for own in courses for course in own.T) > MOVING:
        return True
    turns = 0.0 if period is None else frequency * period
    return period is not None and abs(turns - round(turns)) * (time[-1] - time[0]) < ON_LINE * period


def _share(frequency: float, time: Floats, course: Floats) -> float:
    # The share of a course's variance that the best tone of a given frequency explains.
    columns = np.column_stack([waves(frequency, time), np.ones_like(time)])
    left = course - columns @ np.linalg.lstsq(columns, course, rcond=None)[0]
    return float(1.0 - np.var(left) / max(float(np.var(course)), 1e-300))
