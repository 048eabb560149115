"""Which law a joint needs: the one with the fewest parameters among those that predict held-out motion as well."""

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
LEAST_GAIN = 0.02  # share of the squared error that a law with more parameters must also remove
LEAST_EFFECT = 1e-2  # share of the joint's friction that it must explain: no law is more accurate than that
SURE_STIFFNESS = 0.3  # relative deviation of a bristle's stiffness, up to which the log shows it
STANDARD_ERRORS = 3.0  # by which its held-out error must be smaller


@dataclass(frozen=True)
class Choice:
    """A candidate: its fit, and the held-out residual of every row, (rows,)."""

    fit: LawFit
    heldout: Floats

    @property
    def parameters(self) -> int:
        """Number of fitted parameters."""
        return int(self.fit.x.size)

    @functools.cached_property
    def errors(self) -> Floats:
        """The held-out squared error of every block, in deviations, (blocks,)."""
        problem = self.fit.problem
        weighted = np.square(self.heldout / problem.deviation)
        return np.asarray(np.bincount(problem.gap.blocks.row, weighted), dtype=np.float64)


def choose_law(
    problem: Problem, names: Sequence[str] = CANDIDATES, first: str | None = None
) -> tuple[Choice, list[Choice]]:
    """Fit every law of a list; return the one to take, and all of them in the order of the list.

    A law with more parameters replaces a simpler one when three conditions hold.  Its held-out error is smaller by
    three standard errors over the blocks and by a fiftieth; what it explains is more than a trace of the friction; and
    the log shows its bristle, if it has one.  The ``first`` law to be beaten is the simplest, unless another is named.
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
    # A bristle far stiffer than what the motion shows is not a bristle but a way to change the blur of reversals.
    deviation = np.sqrt(np.diag(fit.normal().known_to(1.0)))
    where = [k for k, name in enumerate(fit.coordinates.names) if name == "bristle_stiffness"]
    return all(deviation[k] < SURE_STIFFNESS for k in where)
