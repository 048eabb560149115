"""Which law a joint needs: the one with the fewest parameters among those that predict motion not fitted as well."""

from __future__ import annotations

import functools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mjfriction.identify.fit import LawFit, fit_law
from mjfriction.identify.problem import Problem
from mjfriction.laws.catalog import find_law
from mjfriction.record.log import Floats

CANDIDATES = (
    "coulomb_viscous",
    "asymmetric",
    "load_dependent",
    "quadratic_viscous",
    "saturating_viscous",
    "stribeck",
    "arctan",
    "dahl",
    "lugre",
)
LEAST_GAIN = 0.02  # of the squared error, that a law with more parameters must take away besides
LEAST_EFFECT = 1e-2  # of the joint's friction, that it must explain: finer than that no law holds
SURE_STIFFNESS = 0.3  # deviation of a bristle's stiffness, relative, up to which the log shows it
STANDARD_ERRORS = 3.0  # by which it must be better on motion not fitted


@dataclass(frozen=True)
class Choice:
    """A candidate: its fit, and what that leaves of every row it has not seen, (rows,)."""

    fit: LawFit
    heldout: Floats

    @property
    def parameters(self) -> int:
        """How many numbers were fitted."""
        return int(self.fit.x.size)

    @functools.cached_property
    def errors(self) -> Floats:
        """The squared error of every block in deviations, on motion not fitted, (blocks,)."""
        problem = self.fit.problem
        weighted = np.square(self.heldout / problem.deviation)
        return np.asarray(np.bincount(problem.gap.blocks.row, weighted), dtype=np.float64)


def choose_law(
    problem: Problem, names: Sequence[str] = CANDIDATES, first: str | None = None
) -> tuple[Choice, list[Choice]]:
    """Fit every law of a list and return the one to take, and all, in the order of the list.

    A law with more parameters takes the place of a simpler one when its error on motion not fitted is smaller by three
    standard errors over the blocks and by a fiftieth, when what it explains is no mere trace of the friction, and when
    the log shows its bristle at all.  The ``first`` to be taken is the simplest, unless another is named.
    """
    choices = []
    for name in names:
        fit = fit_law(problem, find_law(name))
        choices.append(Choice(fit, fit.heldout()))
    trace = float(np.sum(np.square(LEAST_EFFECT * np.std(problem.target) / problem.deviation)))
    named = [choice for choice in choices if choice.fit.law.name == first]
    best = named[0] if named else min(choices, key=lambda choice: choice.parameters)
    able = [choice for choice in choices if choice is best or _shows(choice.fit)]
    for choice in sorted(able, key=lambda choice: (choice.parameters, float(np.sum(choice.errors)))):
        better = best.errors - choice.errors
        error = float(np.std(better, ddof=1)) * np.sqrt(better.size)
        if np.sum(better) > max(STANDARD_ERRORS * error, LEAST_GAIN * float(np.sum(best.errors)), trace):
            best = choice
    return best, choices


def _shows(fit: LawFit) -> bool:
    # A bristle far stiffer than what the motion shows is no bristle but a way to bend the blur of reversals.
    deviation = np.sqrt(np.diag(fit.normal().known_to(1.0)))
    where = [k for k, name in enumerate(fit.coordinates.names) if name == "bristle_stiffness"]
    return all(deviation[k] < SURE_STIFFNESS for k in where)
