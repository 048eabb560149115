"""Formatting of numbers for people and for files."""

from __future__ import annotations

from mjfriction.record.fault import LONG_AGO, moment

WHOLE = 1e7  # from here on, seven digits no longer hold the whole integer part


def digits(value: float, unit: str = "1") -> str:
    """Return a number as text with four digits; a time (s) since 1970 to the millisecond."""
    return moment(value) if unit == "s" and abs(value) >= LONG_AGO else f"{value:.4g}"


def percentage(share: float) -> str:
    """Return a share in whole percent; one that rounds to zero has no sign."""
    return f"{round(100.0 * share, 0) + 0.0:.0f}"


def kept(value: float) -> float:
    """Return a number rounded to seven digits, or to a thousandth where seven digits would be coarser than that."""
    return float(f"{value:.7g}") if abs(value) < WHOLE else round(value, 3)
