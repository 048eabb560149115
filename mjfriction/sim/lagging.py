"""What a link carries that lags behind its motor."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from mjfriction.laws.law import Floats, kernel


class Lagging(NamedTuple):
    """A link along its motor's motion, (n,) each: where it lags behind by s, it carries
    load − stiffness·s − damping·ṡ − inertia·s̈.

    ``load`` is what it would carry if it moved as its motor does, N·m or N; the next three are how that changes with
    its own position, velocity and acceleration.  ``seen`` is what its drive was seen to pass on to it, None where that
    is not known.
    """

    load: Floats
    inertia: Floats
    stiffness: Floats
    damping: Floats
    seen: Floats | None = None

    def over(self, own: slice) -> Lagging:
        """Return the same over a range of samples."""
        load, inertia, stiffness, damping = (np.ascontiguousarray(course[own], dtype=np.float64) for course in self[:4])
        return Lagging(load, inertia, stiffness, damping, None if self.seen is None else self.seen[own])

    def unloaded(self) -> Lagging:
        """Return the same without its load."""
        return self._replace(load=np.zeros_like(self.load), seen=None)


@kernel
def between(
    load: Floats, inertia: Floats, stiffness: Floats, damping: Floats, k: int, share: float
) -> tuple[float, float, float, float]:
    """Return one over a link's inertia, and its load, stiffness and damping over the inertia, at a ``share`` of the way
    from sample k − 1 to sample k, all linear in between.
    """
    aside = 1.0 - share
    worth = 1.0 / (aside * inertia[k - 1] + share * inertia[k])
    drawn = worth * (aside * load[k - 1] + share * load[k])
    stiff = worth * (aside * stiffness[k - 1] + share * stiffness[k])
    return worth, drawn, stiff, worth * (aside * damping[k - 1] + share * damping[k])
