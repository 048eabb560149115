"""Progress reports of long computations; they are dropped unless a caller passes a callback."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from typing import Protocol


class Tell(Protocol):
    """Progress callback: ``step`` names the current step, ``done`` is the finished fraction, 0 to 1, where known."""

    def __call__(self, step: str, done: float | None = None) -> None:
        """Receive a progress report."""
        ...


def silently(step: str, done: float | None = None) -> None:
    """Ignore a progress report."""


def counting(tell: Tell, steps: int) -> Callable[[str], None]:
    """Return a function to call as each of ``steps`` steps begins; it reports the step and the finished fraction."""
    begun = itertools.count()

    def begin(step: str) -> None:
        tell(step, next(begun) / steps)

    return begin
