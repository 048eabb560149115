"""Three screw drives, run at steady speeds (Lang and others): their friction as passes forward and backward give it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from pyarrow import parquet

from mjfriction.identify.friction_map import FrictionMap

LAWS = ("coulomb_viscous", "quadratic_viscous", "saturating_viscous", "stribeck")
PUBLISHED = {1: (4.56, 1.41), 2: (2.10, 2.10), 3: (5.76, 6.75)}
"""Errors (%) left by Coulomb-viscous friction and with a Stribeck curve, one run left out at a time, by drive."""
SAME = 0.1  # relative speed difference below which a run forward and one backward are a pair


def map_of(path: Path) -> FrictionMap:
    """Return the map of half the difference of the runs forward and backward, as from passes."""
    table = parquet.read_table(path)
    velocity, effort, run = (table[name].to_numpy() for name in ("velocity.screw", "effort.screw", "segment"))
    # A run's first sample was edited by hand in one of the files; the median of a run is not affected.
    runs = [
        (np.median(velocity[run == k]), np.median(effort[run == k]), np.std(effort[run == k])) for k in np.unique(run)
    ]
    backward = [(-v, e, s) for v, e, s in runs if v < 0.0]
    points = []
    for v, e, s in sorted(own for own in runs if own[0] > 0.0):
        there, back, spread = min(backward, key=lambda own: abs(own[0] - v))
        if abs(there - v) < SAME * v:
            points.append((0.5 * (v + there), 0.5 * (e - back), 0.5 * float(np.hypot(s, spread))))
    speed, friction, scatter = np.array(points).T
    return FrictionMap(0, speed, friction, np.maximum(scatter, 1e-6), np.zeros(speed.size), np.ones(speed.size))
