"""How long work tells what it is at: a function of one sentence, which does nothing unless someone watches."""

from __future__ import annotations

from collections.abc import Callable

Tell = Callable[[str], None]


def silently(_: str) -> None:
    """Tell nobody."""
