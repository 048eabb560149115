"""How near refitted drives and links are to what is stated, and what it is worth that a cause brings them nearer.

Two dozen numbers of a robot that are each off by a few percent, in exactly the pattern that one cause produces, fit as
well as that cause.  But their distance from what is stated makes them unlikely.  How far a robot's numbers usually are
off is estimated from the numbers themselves.  On a robot where all links but one are right to a percent, that one
stands out.  On a robot that is off throughout, it means little that a cause moves some of them nearer.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mjfriction.diagnose.fit.model import Model
from mjfriction.diagnose.fit.nuisance import Nuisance
from mjfriction.identify.normal import Normal

NEAREST, FARTHEST = 1.0 / 3.0, 3.0  # limits of a robot's spread, relative to how far drives and links usually are off
STRAINED = 64.0  # strain (squared usual deviations) that a cause must save drives and links to count by that alone


@dataclass(frozen=True)
class Nearness:
    """How near drives and links are to what is stated.

    ``spread`` λ is how far this robot's numbers θ are off, relative to the usual σ, between NEAREST and FARTHEST.
    ``shown`` γ is how many of these numbers the motion shows.  ``strain`` is Σ(θ/σ)²/λ² + γ·ln λ², minus twice the log
    likelihood of such θ up to a constant; ``distance`` is Σ(θ/σ)² alone.
    """

    distance: float
    strain: float
    spread: float
    shown: float


def nearness(nuisance: Nuisance, normal: Normal) -> Nearness:
    """Return how near the drives and links of a fit are to what is stated; ``nuisance`` says where they are in it.

    λ² is Σ(θ/σ)²/γ, its most likely value (MacKay, Bayesian interpolation, Neural Computation 4(3), 1992).  Links that
    were let go have no usual distance, so there λ is 1.
    """
    place = nuisance.of_stated
    squares = float(np.sum(normal.precision[place] * np.square(normal.fitted[place])))
    shown = 0.0 if nuisance.inertias is not None else normal.shown(place)
    if shown <= 0.0:
        return Nearness(squares, squares, 1.0, 0.0)
    variance = min(max(squares / shown, NEAREST**2), FARTHEST**2)
    return Nearness(squares, squares / variance + shown * float(np.log(variance)), float(np.sqrt(variance)), shown)


def nearness_of(model: Model) -> Nearness:
    """Return how near a model's drives and links are to what is stated."""
    return nearness(model.nuisance, model.system.normal)


def relief(model: Model, without: Model) -> float:
    """Return how much likelier a model's drives and links are than those of one ``without`` a cause: strain saved, with
    that of friction levels that are kept near what is stated.
    """
    drives_and_links = nearness_of(without).strain - nearness_of(model).strain
    return drives_and_links + _strain_of_levels(without) - _strain_of_levels(model)


def _strain_of_levels(model: Model) -> float:
    # The squares of how many spreads the levels are off that are kept near what is stated.
    nuisance = model.nuisance
    places = [nuisance.of_level(level.site.joint) for level in nuisance.levels if level.near]
    return float(sum(np.sum(nuisance.precision[place] * np.square(model.strengths[place])) for place in places))
