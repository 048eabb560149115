"""One law fitted to one joint: statics first, then what gives before it slides, then all together."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from mjfriction.identify.coordinates import Coordinates
from mjfriction.identify.problem import Problem
from mjfriction.identify.regression import Normal, Rows, System
from mjfriction.identify.starts import DYNAMIC, GIVING_TRAVELS, LEFT_AS_DECLARED, starts
from mjfriction.laws.catalog import find_law
from mjfriction.laws.law import Law
from mjfriction.record.log import Floats
from mjfriction.robot.schema import FrictionTerm

STATIC_SIBLING = {
    "dahl": "coulomb_viscous",
    "lugre": "stribeck",
    "elasto_plastic": "stribeck",
    "dwell_time": "stribeck",
    "lugre_lorentzian": "lorentzian",
    "lugre_arctan": "arctan",
    "lugre_smooth": "arctan",
}
"""The law without a state whose statics are those of a law with one."""

MOST_ROUNDS, FIRST_ROUNDS = 40, 6
DIFFERENCE = 1e-4  # of a coordinate, for the slopes of the rows


@dataclass(frozen=True)
class LawFit:
    """A law fitted to a joint: its ``values``, where they stand as ``coordinates`` and ``x``, and the rows' slopes
    (rows, coordinates) there, in N·m or N per coordinate.
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
    def values(self) -> dict[str, float]:
        """All its parameters."""
        return self.coordinates.values(self.x)

    @property
    def term(self) -> FrictionTerm:
        """The law as it stands in a robot file."""
        return self.problem.term(self.law, self.values)

    @property
    def left(self) -> Floats:
        """What it leaves of the target, (rows,)."""
        return self.problem.target - self.problem.rows(self.term)

    def normal(self) -> Normal:
        """Return the normal equations of a further step of its coordinates and of what is unknown beside it."""
        beside = self.problem.beside
        rows = Rows(self._expected[:, None], 1.0 / self.problem.deviation[:, None], self.problem.gap.blocks.row)
        return System(rows, [{0: self.slopes}, {0: beside.columns}], [self.precision, beside.precision]).normal

    @property
    def _expected(self) -> Floats:
        # What is left with all that is unknown beside the law as it is expected to be.
        return np.asarray(self.left - self.problem.beside.columns @ self.problem.beside.expected)

    @property
    def precision(self) -> Floats:
        """One over the variance that a further step may have where the rows say nothing: of the coordinate's own size,
        a factor of e for a logarithm.
        """
        size = np.maximum(np.abs(self.x), 0.1 * float(np.max(np.abs(self.x))))
        return np.asarray(1.0 / np.square(np.where(self.coordinates.logarithmic, 1.0, size)))

    def heldout(self) -> Floats:
        """Return what is left of every row by a fit that has not seen its block, (rows,).

        The fits without a block are single steps from the fit with all.
        """
        blocks, normal, out = self.problem.gap.blocks, self.normal(), self._expected
        columns = np.hstack([self.slopes, self.problem.beside.columns])
        for fold in blocks.folds:
            rows = fold[blocks.row]
            out[rows] -= columns[rows] @ normal.strengths(~fold)
        return out


def fit_anew(problem: Problem, fit: LawFit) -> LawFit:
    """Return a fit continued on rows that have moved a little."""
    return _best(problem, fit.law, fit.coordinates.names, [fit.values])


def begun(problem: Problem, law: Law) -> LawFit:
    """Return a law at a joint where its fit would begin, with no slopes yet."""
    start = starts(law, problem.usual())[0]
    free = tuple(name for name in start if name not in LEFT_AS_DECLARED)
    coordinates = Coordinates(law, free, {name: start[name] for name in start if name not in free})
    return LawFit(problem, coordinates, coordinates.vector(start), np.empty((problem.target.size, 0)))


def fit_law(problem: Problem, law: Law) -> LawFit:
    """Fit a law to a joint by weighted nonlinear least squares from several starts.

    The statics of a law with a state are those of its sibling without one, fitted first; then, these held, its bristle;
    then all together.  Raises :class:`~mjfriction.errors.LawError` for a law that a log of this kind cannot fix.
    """
    begin = starts(law, problem.usual())
    sibling = STATIC_SIBLING.get(law.name)
    if sibling is not None:
        statics = fit_law(problem, find_law(sibling)).values
        shared = {name: value for name, value in statics.items() if name not in LEFT_AS_DECLARED}
        # The fading speed is known now, so that starts differ in the bristle alone.
        known = {name: value for name, value in shared.items() if name in begin[0]}
        begin = [{**start, **known} for start in begin[: len(GIVING_TRAVELS)]]
        bristle = [name for name in begin[0] if name in DYNAMIC]
        begin = [_best(problem, law, bristle, begin).values]
    free = [name for name in begin[0] if name not in LEFT_AS_DECLARED]
    return _best(problem, law, free, begin)


def _best(problem: Problem, law: Law, free: Sequence[str], begin: list[dict[str, float]]) -> LawFit:
    # A few rounds from every start, and all from the best.
    first = FIRST_ROUNDS if len(begin) > 1 else MOST_ROUNDS
    tried = []
    for start in begin:
        fixed = {name: value for name, value in start.items() if name not in free}
        coordinates = Coordinates(law, tuple(free), fixed)
        tried.append((coordinates, *_descend(problem, coordinates, coordinates.vector(start), first)))
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
    """Return how the rows of a law move with each coordinate, (rows, coordinates), by differences inside the bounds."""
    low, high = coordinates.bounds()
    middle = problem.rows(problem.term(coordinates.law, coordinates.values(x)))
    out = np.empty((middle.size, x.size))
    for k in range(x.size):
        size = DIFFERENCE * max(abs(float(x[k])), 0.1 * float(np.max(np.abs(x))), 1e-3)
        step = np.zeros(x.size)
        step[k] = size if x[k] + size <= high[k] else -size
        if x[k] + step[k] < low[k]:
            step[k] = 0.5 * (high[k] - low[k]) * DIFFERENCE
        out[:, k] = (problem.rows(problem.term(coordinates.law, coordinates.values(x + step))) - middle) / step[k]
    return out
