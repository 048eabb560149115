"""Fit one law to one joint: static parameters first, then what gives before it slides, then all together."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from mjfriction.identify.coordinates import Coordinates
from mjfriction.identify.elements import Elements
from mjfriction.identify.first_elements import first_elements, springs_of
from mjfriction.identify.normal import Normal
from mjfriction.identify.problem import Problem
from mjfriction.identify.regression import Rows, System
from mjfriction.identify.starts import DYNAMIC, GIVING_TRAVELS, LEFT_AS_DECLARED, starts
from mjfriction.laws.catalog import find_law
from mjfriction.laws.law import Law
from mjfriction.laws.rules import Ordering, Values, scalar
from mjfriction.record.log import Floats
from mjfriction.robot.friction_tables import FrictionTerm

STATIC_SIBLING = {
    "dahl": "coulomb_viscous",
    "lugre": "stribeck",
    "elasto_plastic": "stribeck",
    "dwell_time": "stribeck",
    "lugre_lorentzian": "lorentzian",
    "lugre_arctan": "arctan",
    "lugre_smooth": "arctan",
    "maxwell_slip": "coulomb_viscous",
    "leuven": "stribeck",
    "gms": "stribeck",
}
"""The law without a state whose statics are those of a law with one."""

SPRINGS_OF = {"leuven": "maxwell_slip", "gms": "maxwell_slip"}
"""The law whose springs those of another begin as."""

MOST_ROUNDS, FIRST_ROUNDS = 40, 6
QUICKER = (0.2, 1.0, 5.0)  # factors on the usual damping or rate of a bristle, from which fits start
AS_GOOD = 1.01  # factor of the squared error up to which fewer elements are taken
DIFFERENCE = 1e-4  # step for the slopes of the rows, as a share of a coordinate


@dataclass(frozen=True)
class LawFit:
    """A law fitted to a joint.

    ``coordinates`` and ``x`` define its ``values``; ``slopes`` (rows, coordinates) are those of the rows there, in N·m
    or N per coordinate.
    """

    problem: Problem
    coordinates: Coordinates
    x: Floats
    slopes: Floats

    @property
    def law(self) -> Law:
        """The law."""
        return self.coordinates.law

    @property
    def values(self) -> dict[str, float | Sequence[float]]:
        """All its parameters."""
        return self.coordinates.values(self.x)

    @property
    def told(self) -> dict[str, float]:
        """Its free parameters as reported, one number each."""
        return self.coordinates.told(self.x)

    @property
    def term(self) -> FrictionTerm:
        """The law in the form of a robot file."""
        return self.problem.term(self.law, self.values)

    @property
    def left(self) -> Floats:
        """The residual of the target, (rows,)."""
        return self.problem.target - self.problem.rows(self.term)

    def normal(self) -> Normal:
        """Return the normal equations of a further step of its coordinates, together with what is unknown beside it."""
        beside = self.problem.beside
        rows = Rows(self._expected[:, None], 1.0 / self.problem.deviation[:, None], self.problem.gap.blocks.row)
        return System(rows, [{0: self.slopes}, {0: beside.columns}], [self.precision, beside.precision]).normal

    @property
    def _expected(self) -> Floats:
        # The residual with everything unknown beside the law at its expected value.
        return np.asarray(self.left - self.problem.beside.columns @ self.problem.beside.expected)

    @property
    def precision(self) -> Floats:
        """The prior precision of a further step: one over the variance that it may have where the rows say nothing.

        The step is as large as the coordinate's own size, or a factor of e for a logarithm.
        """
        size = np.maximum(np.abs(self.x), 0.1 * float(np.max(np.abs(self.x))))
        return np.asarray(1.0 / np.square(np.where(self.coordinates.logarithmic, 1.0, size)))

    def heldout(self) -> Floats:
        """Return the held-out residual, each row predicted by a fit that has not seen its block, (rows,).

        The fits without some blocks are single steps from the fit to all.
        """
        blocks, normal, out = self.problem.gap.blocks, self.normal(), self._expected
        columns = np.hstack([self.slopes, self.problem.beside.columns])
        for fold in blocks.folds:
            rows = fold[blocks.row]
            out[rows] -= columns[rows] @ normal.strengths(~fold)
        return out


def fit_anew(problem: Problem, fit: LawFit) -> LawFit:
    """Return a fit continued on rows that have changed a little."""
    return _best(problem, [(fit.coordinates, fit.x)])


def begun(problem: Problem, law: Law) -> LawFit:
    """Return a law at a joint with the values its fit would start from, and without slopes."""
    start = starts(law, problem.usual())[0]
    free = tuple(name for name in start if name not in LEFT_AS_DECLARED)
    coordinates = Coordinates(law, free, {name: start[name] for name in start if name not in free})
    return LawFit(problem, coordinates, coordinates.vector(start), np.empty((problem.target.size, 0)))


def fit_law(problem: Problem, law: Law) -> LawFit:
    """Fit a law to a joint by weighted nonlinear least squares from several starts.

    The static parameters of a law with a state come from its sibling without one, which is fitted first.  Then its
    bristle is fitted with these held, then everything together.  Elements are added as long as the held-out error
    falls, then merged where fewer fit as well.
    """
    plain: list[Values] = list(starts(law, problem.usual()))
    begin = plain
    free = [name for name in begin[0] if name not in LEFT_AS_DECLARED]
    sibling = STATIC_SIBLING.get(law.name)
    if sibling is not None:
        statics = fit_law(problem, find_law(sibling)).told
        # The fading speed is known now, so the starts differ only in the bristle.
        known = {name: value for name, value in statics.items() if name in free}
        begin = [with_known(law, start, known) for start in plain[: len(GIVING_TRAVELS)]]
    simpler = SPRINGS_OF.get(law.name)
    if simpler is not None:
        elements, arrays = springs_of(law, fit_law(problem, find_law(simpler)).values)
        # Where most of the motion is presliding, the sibling's static parameters are unreliable, so start from the
        # plain ones too.
        slow = [name for name in free if name not in DYNAMIC]
        whole = _best(problem, [_at(law, slow, {**start, **arrays}, elements) for start in [begin[0], *plain]]).values
        quick = [{name: factor * scalar(whole, name) for name in free if name in DYNAMIC} for factor in QUICKER]
        return _thinned(problem, _best(problem, [_at(law, free, {**whole, **own}, elements) for own in quick]))
    if law.elements:
        elements, arrays = first_elements(problem, law)
        return _thinned(problem, _best(problem, [_at(law, free, {**begin[0], **arrays}, elements)]))
    if sibling is not None:
        bristle = [name for name in free if name in DYNAMIC]
        first = _best(problem, [_at(law, bristle, start) for start in begin]).values
        # Where much of the motion is presliding, the sibling mistakes it for a falling level, so start from the plain
        # values too.
        given = {name: first[name] for name in bristle}
        begin = [first, *({**start, **given} for start in plain[:: len(GIVING_TRAVELS)])]
    return _best(problem, [_at(law, free, start) for start in begin])


def with_known(law: Law, start: Values, known: Values) -> Values:
    """Return a start with the known values put in.

    A value that is not known, but has to exceed another one, ends up at least as many times above it as in the start.
    """
    values = {**start, **known}
    for rule in law.rules:
        if isinstance(rule, Ordering) and rule.larger not in known:
            least = scalar(values, rule.smaller) * scalar(start, rule.larger) / scalar(start, rule.smaller)
            values[rule.larger] = max(scalar(values, rule.larger), least)
    return values


def _thinned(problem: Problem, fit: LawFit) -> LawFit:
    # Two elements that were grown on a grid of candidates may stand for a single one between two grid points.
    while fit.coordinates.elements is not None and fit.coordinates.elements.count > 1:
        fewer, values = fit.coordinates.elements.fewer(fit.values)
        less = _best(problem, [_at(fit.law, fit.coordinates.single, values, fewer)])
        errors = [float(np.sum(np.square(problem.left(own.term)))) for own in (fit, less)]
        if errors[1] > AS_GOOD * errors[0]:
            break
        fit = less
    return fit


def _at(law: Law, free: Sequence[str], values: Values, elements: Elements | None = None) -> tuple[Coordinates, Floats]:
    single = {parameter.name: scalar(values, parameter.name) for parameter in law.parameters}
    fixed = {name: value for name, value in single.items() if name not in free}
    coordinates = Coordinates(law, tuple(name for name in single if name in free), fixed, elements)
    return coordinates, coordinates.vector(values)


def _best(problem: Problem, begin: list[tuple[Coordinates, Floats]]) -> LawFit:
    # Take a few rounds from every start, and all rounds from the best.
    first = FIRST_ROUNDS if len(begin) > 1 else MOST_ROUNDS
    tried = []
    for coordinates, start in begin:
        tried.append((coordinates, *_descend(problem, coordinates, start, first)))
    coordinates, x, _ = min(tried, key=lambda entry: entry[2])
    if first < MOST_ROUNDS:
        x, _ = _descend(problem, coordinates, x, MOST_ROUNDS)
    return LawFit(problem, coordinates, x, slopes(problem, coordinates, x))


def _descend(problem: Problem, coordinates: Coordinates, start: Floats, rounds: int) -> tuple[Floats, float]:
    low, high = coordinates.bounds()
    inside = np.clip(start, np.nextafter(low, np.inf), np.nextafter(high, -np.inf))

    def left(x: Floats) -> Floats:
        return problem.left(problem.term(coordinates.law, coordinates.values(x)))

    def jacobian(x: Floats) -> Floats:
        return problem.freed(slopes(problem, coordinates, x))

    found = least_squares(
        left, inside, jac=jacobian, bounds=(low, high), x_scale="jac", max_nfev=rounds, ftol=1e-6, xtol=1e-6
    )
    return np.asarray(found.x), 2.0 * float(found.cost)


def slopes(problem: Problem, coordinates: Coordinates, x: Floats) -> Floats:
    """Return the derivatives of a law's rows by each coordinate, (rows, coordinates), by differences within bounds."""
    low, high = coordinates.bounds()
    middle = problem.rows(problem.term(coordinates.law, coordinates.values(x)))
    out = np.empty((middle.size, x.size))
    logarithmic = coordinates.logarithmic
    least = np.where(logarithmic, 1.0, max(0.1 * float(np.max(np.abs(x[~logarithmic]), initial=0.0)), 1e-3))
    for k in range(x.size):
        size = DIFFERENCE * min(max(abs(float(x[k])), float(least[k])), 0.5 * float(high[k] - low[k]))
        step = np.zeros(x.size)
        step[k] = size if x[k] + size <= high[k] else -size
        out[:, k] = (problem.rows(problem.term(coordinates.law, coordinates.values(x + step))) - middle) / step[k]
    return out
