"""A fault of a log: what the recording itself brought into it, where, and what was done about it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from mjfriction.record.span import EVER, Span

MOST_LISTED = 3  # places of one fault that are spelled out
LONG_AGO = 1e5  # s, past which a clock did not begin with its log


@dataclass(frozen=True)
class Mend:
    """How columns of a log should have been read: times a factor each, or two in each other's place, within a ``span``
    of time (s).
    """

    factors: tuple[tuple[str, float], ...] = ()
    exchanged: tuple[tuple[str, str], ...] = ()
    span: Span = EVER


@dataclass(frozen=True)
class Fault:
    """A fault of a log: its ``kind`` (``data.stuck``, …), where, and what was done or is to do; ``spans`` are the
    times (s) of the rows that were left out, ``mend`` is how the log is read right where that is known.
    """

    kind: str
    where: str
    action: str
    spans: tuple[Span, ...] = ()
    mend: Mend | None = None


def in_words(places: Sequence[tuple[float, float]]) -> str:
    """Return stretches of time (s) as words, all but the first few of them counted."""
    words = [f"{moment(a)} s" if a == b else f"{moment(a)} s to {moment(b)} s" for a, b in places[:MOST_LISTED]]
    more = len(places) - MOST_LISTED
    return ", ".join(words) + (f" and {more} more places" if more > 0 else "")


def moment(time: float) -> str:
    """Return a time (s) in figures; seconds since 1970 have ten before the point."""
    return f"{time:.6g}" if abs(time) < LONG_AGO else f"{time:.3f}"
