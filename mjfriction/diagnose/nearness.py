"""How near refitted drives and links are to what is stated, and what it is worth that a cause brings them nearer.

Two dozen numbers of a robot that are each a few percent off, in just such a way as one cause would ask for, fit as well
as that cause; but they are as unlikely as their distance from what is stated says.  How far a robot's numbers usually
are off is seen from themselves: on one of which all links but one are right to a percent, that one stands out; on one
that is off throughout, that a cause moves some of them nearer says little.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mjfriction.diagnose.model import Model
from mjfriction.diagnose.nuisance import Nuisance
from mjfriction.identify.normal import Normal

NEAREST, FARTHEST = 1.0 / 3.0, 3.0  # of how far stated drives and links usually are off, that a robot's are
STRAINED = 25.0  # of distance from what is stated, in squares of what is the rule, that a cause must save the rest


@dataclass(frozen=True)
class Nearness:
    """How near drives and links are to what is stated.

    ``spread`` λ is how far this robot's are off, relative to the σ that is usual, between NEAREST and FARTHEST;
    ``shown`` γ how many of their numbers θ the motion shows; ``strain`` Σ(θ/σ)²/λ² + γ·ln λ², minus twice the logarithm
    of how likely such θ are, but for a constant; ``distance`` Σ(θ/σ)² alone.
    """

    distance: float
    strain: float
    spread: float
    shown: float


def nearness(nuisance: Nuisance, normal: Normal) -> Nearness:
    """Return how near the drives and links of a fit are to what is stated; ``nuisance`` says where they stand in it.

    λ² is Σ(θ/σ)²/γ, the most likely of all (MacKay, Bayesian interpolation, Neural Computation 4(3), 1992).  Of links
    that were let go, no distance is usual.
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
    """Return by how much more likely the drives and links of a model are than those of one ``without`` a cause."""
    return nearness_of(without).strain - nearness_of(model).strain
