"""How long work tells what it is at; nobody hears it unless someone watches."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from typing import Protocol


class Tell(Protocol):
    """Hears what is going on: ``step`` in a few words, and how much of the whole is ``done``, 0 to 1, where known."""

    def __call__(self, step: str, done: float | None = None) -> None:
        """Hear it."""
        ...


def silently(step: str, done: float | None = None) -> None:
    """Tell nobody."""


def counting(tell: Tell, steps: int) -> Callable[[str], None]:
    """Return what is told each of so many steps as it begins, and tells with it what share of them is over."""
    begun = itertools.count()

    def begin(step: str) -> None:
        tell(step, next(begun) / steps)

    return begin
