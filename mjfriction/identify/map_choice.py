"""Which law a joint's passes need: the simplest among those that predict left-out speeds as well."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.stats import f as variance_ratio

from mjfriction.errors import LogError
from mjfriction.identify.friction_map import FrictionMap
from mjfriction.identify.map_fit import MapFit, fit_map, static_names
from mjfriction.identify.problem import Side
from mjfriction.laws.law import Law

# Probability that two laws' squared errors differ as much by chance (Fisher's F); speeds are too few for blocks.
CHANCE = 0.05


def choose_on_map(points: FrictionMap, laws: Sequence[Law], side: Side, gear_ratio: float) -> list[MapFit]:
    """Return the fits of the laws that a map has enough speeds for, the one to take first.

    Speeds are left out one at a time.  A law with more parameters replaces a simpler one when its errors are smaller
    than chance would explain.

    Raises :class:`LogError` where there are too few for any.
    """
    tried = []
    for law in laws:
        if points.speed.size > len(static_names(law)) + 1:
            tried.append(fit_map(points, law, side, gear_ratio))
    if not tried:
        least = min(len(static_names(law)) for law in laws) + 2
        raise LogError(f"{points.speed.size} speeds are too few to choose a law by; record at least {least}")
    tried.sort(key=lambda choice: (len(static_names(choice.law)), float(np.sum(np.square(choice.missed)))))
    best = tried[0]
    for choice in tried[1:]:
        freedoms = [points.speed.size - len(static_names(one.law)) for one in (best, choice)]
        ratio = float(np.sum(np.square(best.missed)) / max(np.sum(np.square(choice.missed)), 1e-300))
        if ratio > variance_ratio.ppf(1.0 - CHANCE, *freedoms):
            best = choice
    return [best, *(choice for choice in tried if choice is not best)]
