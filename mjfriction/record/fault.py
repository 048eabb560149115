"""Faults of a log: errors that the recording itself introduced, where, and what was done about them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from mjfriction.record.span import EVER, Span

MOST_LISTED = 3  # places of one fault that are written out
LONG_AGO = 1e5  # s; a clock beyond this did not start with its log


@dataclass(frozen=True)
class Mend:
    """How columns of a log should have been read within a ``span`` of time (s): each multiplied by its factor, or two
    columns exchanged.
    """

    factors: tuple[tuple[str, float], ...] = ()
    exchanged: tuple[tuple[str, str], ...] = ()
    span: Span = EVER


@dataclass(frozen=True)
class Fault:
    """A fault of a log: its ``kind`` (``data.stuck``, …), where it is, and the action taken or needed.

    ``spans`` are the times (s) of the rows that were left out.  ``mend`` is how to read the log correctly, where known.
    """

    kind: str
    where: str
    action: str
    spans: tuple[Span, ...] = ()
    mend: Mend | None = None


def in_words(places: Sequence[tuple[float, float]]) -> str:
    """Return stretches of time (s) as text: the first few written out, the rest as a count."""
    words = [f"{moment(a)} s" if a == b else f"{moment(a)} s to {moment(b)} s" for a, b in places[:MOST_LISTED]]
    more = len(places) - MOST_LISTED
    return ", ".join(words) + (f" and {more} more places" if more > 0 else "")


def moment(time: float) -> str:
    """Return a time (s) as text; to the millisecond for seconds since 1970, which have ten digits before the point."""
    return f"{time:.6g}" if abs(time) < LONG_AGO else f"{time:.3f}"
