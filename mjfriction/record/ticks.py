"""The unit of a log's clock, chosen by its usual step."""

from __future__ import annotations

TICKS = {"seconds": 1.0, "milliseconds": 1e-3, "microseconds": 1e-6, "nanoseconds": 1e-9}
STEPS = (1e-4, 0.1)  # s, shortest and longest step of logs that can be used


def tick_of(step: float) -> str:
    """Return the longest unit of :data:`TICKS` in which a log with this ``step`` is sampled at 10 Hz to 10 kHz, or
    seconds where there is none.
    """
    return next((unit for unit, worth in TICKS.items() if STEPS[0] <= step * worth <= STEPS[1]), "seconds")
