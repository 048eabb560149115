"""Positions in a unit they should not be in."""

from __future__ import annotations

import numpy as np

from mjfriction.body.model import Body
from mjfriction.record.faults import Fault
from mjfriction.record.log import POSITION, Log


def find_unit_faults(log: Log, body: Body) -> list[Fault]:
    """Return the positions that lie so far outside a joint's limits that their unit must be another.

    Degrees for radians, or millimetres for metres, leave the limits by more than the whole range between them.
    """
    out = []
    for i, joint in enumerate(body.joints):
        values = log.channel(POSITION, joint)
        span = body.upper[i] - body.lower[i]
        if values is None or not np.isfinite(span) or span <= 0.0:
            continue
        low, high = float(np.min(values)), float(np.max(values))
        if low < body.lower[i] - span or high > body.upper[i] + span:
            unit, other = ("m", "millimetres") if body.sliding[i] else ("rad", "degrees")
            action = (
                f"it runs from {low:.4g} to {high:.4g} {unit}, where the model's limits are {body.lower[i]:.4g} to "
                f"{body.upper[i]:.4g} {unit}; convert it if it is in {other}"
            )
            out.append(Fault("data.unit", f"position.{joint}", action))
    return out
