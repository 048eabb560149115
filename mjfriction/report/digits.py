"""Numbers as a person reads them, and as a file keeps them."""

from __future__ import annotations

from mjfriction.record.fault import LONG_AGO, moment

WHOLE = 1e7  # from which on seven digits lose what is before the point


def digits(value: float, unit: str = "1") -> str:
    """Return a number of a unit in four digits; of a clock that counts since 1970, to the millisecond."""
    return moment(value) if unit == "s" and abs(value) >= LONG_AGO else f"{value:.4g}"


def percentage(share: float) -> str:
    """Return a share in whole percent; what is next to nothing has no sign."""
    return f"{round(100.0 * share, 0) + 0.0:.0f}"


def kept(value: float) -> float:
    """Return a number to seven digits, or to a thousandth where it is so large that these would lose that."""
    return float(f"{value:.7g}") if abs(value) < WHOLE else round(value, 3)
