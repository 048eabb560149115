"""The ambient quantities of a friction contact: what a law may depend on besides velocity."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

LOAD, POSITION, TEMPERATURE, PRESSURE_HEAD, PRESSURE_ROD, SLIDING, ROTOR, AMBIENT_SIZE = range(8)
ROOM_TEMPERATURE = 25.0  # °C, assumed where no temperature is measured

Floats = NDArray[np.float64]


def ambient(
    count: int,
    *,
    load: Floats | float = 0.0,
    position: Floats | float = 0.0,
    temperature: Floats | float = ROOM_TEMPERATURE,
    pressure_head: Floats | float = 0.0,
    pressure_rod: Floats | float = 0.0,
    sliding: Floats | float = math.nan,
    rotor: Floats | float = 0.0,
) -> Floats:
    """Return the ambient quantities of ``count`` samples, shape (count, 7), as the kernels read them row by row.

    ``load``: the torque that the transmission carries, N·m or N.  ``position``: rad or m.  ``temperature``: °C.
    ``pressure_head`` and ``pressure_rod``: Pa in the two chambers of a hydraulic cylinder.  ``sliding``: the velocity
    at which laws that fall with speed evaluate their level, rad/s or m/s; NaN for the velocity of the step itself.
    ``rotor``: the additional torque of the drive's own rotor, N·m or N.  Each is one number or has shape (count,).
    """
    out = np.empty((count, AMBIENT_SIZE))
    for column, value in enumerate((load, position, temperature, pressure_head, pressure_rod, sliding, rotor)):
        out[:, column] = value
    return out
