"""What a link carries that lags behind its motor."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from mjfriction.laws.law import Floats


class Lagging(NamedTuple):
    """A link along its motor's motion, (n,) each: where it lags behind by s, it carries
    load − stiffness·s − damping·ṡ − inertia·s̈.

    ``load`` is what it would carry if it moved as its motor does, N·m or N; the others are how that changes with its
    own position, velocity and acceleration.
    """

    load: Floats
    inertia: Floats
    stiffness: Floats
    damping: Floats

    def over(self, own: slice) -> Lagging:
        """Return the same over a range of samples."""
        return Lagging(*(np.ascontiguousarray(course[own], dtype=np.float64) for course in self))
