"""What one unit of a log's clock is worth, by its usual step."""

from __future__ import annotations

TICKS = {"seconds": 1.0, "milliseconds": 1e-3, "microseconds": 1e-6, "nanoseconds": 1e-9}
STEPS = (1e-4, 0.1)  # s, of logs that can be used


def tick_of(step: float) -> str:
    """Return the unit, of :data:`TICKS`, in which a log with such steps is one of 10 Hz to 10 kHz: the longest, or
    seconds where none is.
    """
    return next((unit for unit, worth in TICKS.items() if STEPS[0] <= step * worth <= STEPS[1]), "seconds")
