"""Least squares over blocks of motion: everything the diagnosis needs of the data, as small matrices.

The weighted rows of a joint enter only through their products, summed per block.  The gain of a further column follows
from these products and its own.
"""

from __future__ import annotations

import functools
import itertools
from collections.abc import Iterable, Mapping
from copy import copy
from dataclasses import dataclass, replace

import numpy as np

from mjfriction.identify.normal import Normal, Part, Products, solved, whitening
from mjfriction.record.log import Floats, Integers

Columns = Mapping[int, Floats]
"""A block of regressor columns: joint index → rows (rows, k), in units of effort per unit of strength."""

UNSEEN = 1e-6  # of the largest column of the same candidate: a smaller column is rounding, not motion


@dataclass(frozen=True)
class Rows:
    """The target of the regression, its weights and its blocks.

    ``target`` (rows, joints): effort to be explained.  ``weight`` (rows, joints): one over the deviation of each row, 0
    where nothing is measured.  ``block`` (rows,): 0 … blocks−1, in one run of rows or in several.
    """

    target: Floats
    weight: Floats
    block: Integers

    @property
    def joints(self) -> int:
        """How many joints."""
        return int(self.target.shape[1])

    @functools.cached_property
    def blocks(self) -> int:
        """How many blocks."""
        return int(np.max(self.block)) + 1

    @functools.cached_property
    def runs(self) -> list[tuple[int, int]]:
        """The runs of rows of one block each, (first, past)."""
        bounds = [0, *(np.flatnonzero(np.diff(self.block)) + 1).tolist(), self.block.size]
        return list(itertools.pairwise(bounds))

    def products(self, left: Floats, right: Floats) -> Floats:
        """Return leftᵀ·right summed within blocks: (rows, a), (rows, b) → (blocks, a, b)."""
        out = np.zeros((self.blocks, left.shape[1], right.shape[1]))
        for first, past in self.runs:
            out[self.block[first]] += left[first:past].T @ right[first:past]
        return out


class System:
    """Rows with the regressors that are in the model so far; further ones can be tried against it.

    For each joint, ``felt`` holds the indices of the regressors that act on it, and ``told`` holds these columns
    followed by the target, weighted, (rows, felt + 1).
    """

    def __init__(self, rows: Rows, columns: list[Columns], precisions: list[Floats]) -> None:
        """Set up the equations; ``precisions`` holds one prior precision (k,) for each block of columns."""
        self.rows = rows
        precision = np.concatenate(precisions) if precisions else np.empty(0)
        self.count = precision.size
        # Few of all regressors act on a joint: only those are kept, weighted.
        felt = [_joint_columns(rows, columns, precisions, joint) for joint in range(rows.joints)]
        self.felt = [place for place, _ in felt]
        self.told = [
            np.column_stack([own, rows.target[:, joint]]) * rows.weight[:, [joint]]
            for joint, (_, own) in enumerate(felt)
        ]
        parts = tuple(self._part_of(joint) for joint in range(rows.joints))
        self.normal = Normal(Products(parts, self.count), precision)

    def _part_of(self, joint: int) -> Part:
        return _part(self.felt[joint], self.rows.products(self.told[joint], self.told[joint]))

    def reweighted(self, weight: Floats, joints: Iterable[int]) -> System:
        """Return the system with another ``weight`` (rows, joints) for the rows of some ``joints``."""
        out = copy(self)
        out._forget()
        whole = self.rows.weight.copy()
        out.told = list(self.told)
        parts = list(self.normal.products.parts)
        for joint in joints:
            before = self.rows.weight[:, joint]
            change = np.divide(weight[:, joint], before, out=np.zeros_like(before), where=before > 0.0)
            whole[:, joint] = weight[:, joint]
            out.told[joint] = self.told[joint] * change[:, None]
            parts[joint] = out._part_of(joint)
        out.rows = replace(self.rows, weight=whole)
        out.normal = Normal(Products(tuple(parts), self.count), self.normal.precision)
        return out

    def kept_within(self, place: slice, reach: Floats) -> System:
        """Return the system with some strengths kept within their ``reach``, as :meth:`Normal.kept_within` does."""
        kept = copy(self)
        kept.normal = self.normal.kept_within(place, reach)
        kept._forget()
        return kept

    def _forget(self) -> None:
        # The cached quantities for screening belong to the equations as they were.
        for name in ("_kept", "_kept_of_joints", "_whitened"):
            self.__dict__.pop(name, None)

    def averaged(self, count: int) -> Normal:
        """Return the normal equations of means over up to ``count`` adjacent rows of a block.

        The weights are those of the rows.  Noise, and anything as fast, nearly vanishes in the means.
        """
        block = self.rows.block
        first = np.concatenate([np.arange(begin, past, count) for begin, past in self.rows.runs])
        size = np.diff(np.append(first, block.size))
        thin = Rows(self.rows.target[first], self.rows.weight[first], block[first])
        means = [np.add.reduceat(told, first, axis=0) / np.sqrt(size)[:, None] for told in self.told]
        parts = tuple(_part(felt, thin.products(own, own)) for felt, own in zip(self.felt, means, strict=True))
        return Normal(Products(parts, self.count), self.normal.precision)

    def residual(self, strengths: Floats) -> Floats:
        """Return what given strengths leave of the target, unweighted, (rows, joints); 0 where nothing is measured."""
        pairs = zip(self.told, self.felt, strict=True)
        left = np.column_stack([told[:, -1] - told[:, :-1] @ strengths[felt] for told, felt in pairs])
        weight = self.rows.weight
        return np.divide(left, weight, out=np.zeros_like(left), where=weight > 0.0)

    def screen(self, block: Columns, every: int = 1) -> tuple[Floats, Floats]:
        """Try many candidates of one kind at once.

        ``block`` holds, for each joint, the columns (rows/every, K, k) of K candidates with k strengths each.  With
        ``every`` above 1, each ``every``-th row stands for all rows.  Returns the candidates' strengths (K, k) and
        gains (K,): by how much each lowers the weighted squared error when fitted together with everything in the
        model.
        """
        _, number, count = next(iter(block.values())).shape
        cross = np.zeros((self.normal.count, number * count))
        own = np.zeros((number, count, count))
        moment = np.zeros((number, count))
        for joint, columns in block.items():
            # Apply the weights to the model's few columns, or to the products, rather than to the columns of all
            # candidates.
            told, counts = self._screened_by(joint, every)
            crossed = told @ columns.reshape(columns.shape[0], -1)
            cross[self.felt[joint]] += crossed[:-1]
            moment += crossed[-1].reshape(number, count)
            for i in range(count):
                for k in range(i + 1):
                    own[:, i, k] += counts @ (columns[:, :, i] * columns[:, :, k])
        for i in range(count):
            own[:, :i, i] = own[:, i, :i]
        whitened, fitted = self._thinned(every)
        held = (whitened @ cross).reshape(-1, number, count).transpose(1, 2, 0)
        reduced = own - np.matmul(held, np.swapaxes(held, 1, 2))
        score = moment - (fitted @ cross).reshape(number, count)
        # A column that the model already contains, or that the motion does not show, gets zero strength instead of a
        # division by zero.
        diagonal = np.einsum("kii->ki", reduced)
        full = np.einsum("kii->ki", own)
        dead = (diagonal <= 1e-6 * full) | (full <= UNSEEN**2 * np.max(full, axis=1, keepdims=True))
        reduced[dead] = 0.0
        np.swapaxes(reduced, 1, 2)[dead] = 0.0
        score[dead] = 0.0
        np.einsum("kii->ki", reduced)[:] = np.where(dead, 1.0, diagonal * (1.0 + 1e-9))
        strengths = np.linalg.solve(reduced, score[:, :, None])[:, :, 0]
        return strengths, np.einsum("ki,ki->k", score, strengths)

    def _thinned(self, every: int) -> tuple[Floats, Floats]:
        # The whitening matrix of the model's regressors, and the model's strengths, on the rows that candidates are
        # screened on.  From other rows, what is left of a column that the model nearly contains would be lost in a
        # difference, and the model's residual would look larger than it is.
        if every == 1:
            return self._whitened
        if every not in self._kept:
            gram, moment = np.diag(self.normal.precision), np.zeros(self.normal.count)
            for told, felt in zip(self.told, self.felt, strict=True):
                thin = told[::every]
                whole = every * thin.T @ thin
                gram[np.ix_(felt, felt)] += whole[:-1, :-1]
                moment[felt] += whole[:-1, -1]
            self._kept[every] = whitening(gram), solved(gram, moment)
        return self._kept[every]

    def _screened_by(self, joint: int, every: int) -> tuple[Floats, Floats]:
        # A joint's regressors and target, (felt + 1, rows/every), weighted once more because the candidates' columns
        # are not weighted; and the squared weights of its rows.
        if (joint, every) not in self._kept_of_joints:
            weight = self.rows.weight[::every, joint]
            told = every * weight[:, None] * self.told[joint][::every]
            self._kept_of_joints[joint, every] = np.asarray(told.T), every * weight**2
        return self._kept_of_joints[joint, every]

    @functools.cached_property
    def _kept_of_joints(self) -> dict[tuple[int, int], tuple[Floats, Floats]]:
        return {}

    @functools.cached_property
    def _whitened(self) -> tuple[Floats, Floats]:
        return whitening(self.normal.equations()[0]), self.normal.fitted

    @functools.cached_property
    def _kept(self) -> dict[int, tuple[Floats, Floats]]:
        return {}

    def extended(self, candidate: Columns, precision: Floats) -> Normal:
        """Return the normal equations with a candidate's columns added at the end."""
        more, new = {}, self.count + np.arange(precision.size)
        for joint, columns in candidate.items():
            part, weighted = self.normal.products.parts[joint], columns * self.rows.weight[:, [joint]]
            own = self.rows.products(np.hstack([self.told[joint], weighted]), weighted)
            felt = part.felt.size
            cross = own[:, :felt]
            gram = np.block([[part.gram, cross], [np.swapaxes(cross, 1, 2), own[:, felt + 1 :]]])
            moment = np.hstack([part.moment, own[:, felt]])
            more[joint] = Part(np.append(part.felt, new), gram, moment, part.power)
        products = self.normal.products.extended(more, precision.size)
        return Normal(products, np.append(self.normal.precision, precision))


def _part(felt: Integers, whole: Floats) -> Part:
    # Make a part of the products of a joint's columns with themselves, the target being the last column.
    return Part(felt, whole[:, :-1, :-1], whole[:, :-1, -1], whole[:, -1, -1])


def _joint_columns(rows: Rows, blocks: list[Columns], precisions: list[Floats], joint: int) -> tuple[Integers, Floats]:
    # The indices of the regressors that act on a joint, and their columns, (rows, felt).
    places, parts, end = [np.empty(0, dtype=np.int64)], [np.empty((rows.block.size, 0))], 0
    for block, precision in zip(blocks, precisions, strict=True):
        start, end = end, end + precision.size
        if joint in block:
            shown = np.any(block[joint], axis=0)
            places.append(start + np.flatnonzero(shown))
            parts.append(block[joint][:, shown])
    return np.concatenate(places), np.concatenate(parts, axis=1)
