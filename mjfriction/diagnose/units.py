"""Positions in a unit they should not be in."""

from __future__ import annotations

import numpy as np

from mjfriction.body.model import Body
from mjfriction.errors import LogError
from mjfriction.record.log import POSITION, Log


def check_units(log: Log, body: Body) -> None:
    """Raise :class:`LogError` when positions lie so far outside a joint's limits that their unit must be another.

    Degrees for radians, or millimetres for metres, leave the limits by more than the whole range between them.
    """
    for i, joint in enumerate(body.joints):
        values = log.channel(POSITION, joint)
        span = body.upper[i] - body.lower[i]
        if values is None or not np.isfinite(span) or span <= 0.0:
            continue
        low, high = float(np.min(values)), float(np.max(values))
        if low < body.lower[i] - span or high > body.upper[i] + span:
            unit, other = ("m", "millimetres") if body.sliding[i] else ("rad", "degrees")
            raise LogError(
                f"{log.source}: column 'position.{joint}' runs from {low:.4g} to {high:.4g} {unit}, but the model's "
                f"limits are {body.lower[i]:.4g} to {body.upper[i]:.4g} {unit}; convert it if it is in {other}"
            )
