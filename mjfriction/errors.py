"""Everything that can go wrong, as one tree.

::

    MjfrictionError
    └── InputError            something the user gave is wrong (exit status 2)
        ├── LogError          a log: columns, rows, sampling
        ├── RobotError        a robot.toml or its model file
        ├── LawError          a friction law's name or parameters
        ├── SimulationError   a MuJoCo model or simulation that cannot carry friction
        ├── ControlError      an observer or a controller that cannot work as it is set
        ├── OutputError       a place where results cannot be written
        └── BenchmarkError    a tool under benchmark that failed

Every message is one line: what was given, what is allowed, what to do.  Any other exception is a failure of our own; a
command then ends with exit status 1.
"""

from __future__ import annotations

import difflib
from collections.abc import Iterable

NO_DIGITS = str.maketrans("", "", "0123456789")


class MjfrictionError(Exception):
    """Base of every exception this package raises on purpose."""


class InputError(MjfrictionError):
    """Something the user gave is wrong; the message says what is wrong and how to fix it."""


class LogError(InputError):
    """A log cannot be read or used."""


class RobotError(InputError):
    """A robot file, or the model file it names, cannot be read or used."""


class LawError(InputError):
    """A friction law is unknown or its parameters are not allowed."""


class SimulationError(InputError):
    """A MuJoCo model cannot carry friction, or a simulation has broken down."""


class ControlError(InputError):
    """An observer or a controller cannot work with the gains it was given."""


class OutputError(InputError):
    """Results cannot be written where they were asked for."""


class BenchmarkError(InputError):
    """A tool under benchmark failed."""


def suggestion(word: str, allowed: Iterable[str]) -> str:
    """Return the end of a sentence: ``"; did you mean 'x'?"`` for the nearest allowed word, or a full stop.

    Words that differ in single digits alone, as the names of joints do, are not mistaken for one another.
    """
    others = [own for own in allowed if len(own) != len(word) or own.translate(NO_DIGITS) != word.translate(NO_DIGITS)]
    near = difflib.get_close_matches(word, others, n=1)
    return f"; did you mean '{near[0]}'?" if near else "."
