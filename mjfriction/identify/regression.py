"""Least squares over blocks of motion: everything the diagnosis needs of the data, as small matrices.

The weighted rows of a joint enter only through their products summed per block.  From these come the fit on any set of
blocks, its error on the others, intervals that survive coloured noise, and what a further column would gain, all
without going back to the rows.
"""

from __future__ import annotations

import functools
import itertools
from collections.abc import Iterable, Mapping
from copy import copy
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve, cholesky, solve_triangular

from mjfriction.record.log import Floats, Integers

Columns = Mapping[int, Floats]
"""A block of regressor columns: joint index → rows (rows, k), in units of effort per unit of strength."""

WITHIN = 1.05  # of its reach, that a strength may go to
MOST_TIGHTER = 20  # times that what is known beforehand of it is drawn tighter
UNSEEN = 1e-6  # of a block's largest column: a smaller one is rounding, not motion


@dataclass(frozen=True)
class Rows:
    """The equation system's left side.

    ``target`` (rows, joints): effort to be explained.  ``weight`` (rows, joints): one over the deviation a row is
    believed to, 0 where there is none.  ``block`` (rows,): 0 … blocks−1.
    """

    target: Floats
    weight: Floats
    block: Integers

    @property
    def joints(self) -> int:
        """How many joints."""
        return int(self.target.shape[1])

    @property
    def blocks(self) -> int:
        """How many blocks."""
        return int(self.block[-1]) + 1

    def products(self, left: Floats, right: Floats) -> Floats:
        """Return leftᵀ·right summed within blocks: (rows, a), (rows, b) → (blocks, a, b)."""
        starts = np.searchsorted(self.block, np.arange(self.blocks))
        bounds = [*starts.tolist(), self.block.size]
        return np.stack([left[a:b].T @ right[a:b] for a, b in itertools.pairwise(bounds)])


@dataclass(frozen=True)
class Normal:
    """Normal equations per joint and block of ``columns`` regressors.

    ``gram`` (joints, blocks, p, p), ``moment`` (joints, blocks, p), ``power`` (joints, blocks) of the target,
    ``precision`` (p,): one over the prior variance of each strength, 0 where nothing is known beforehand.
    """

    gram: Floats
    moment: Floats
    power: Floats
    precision: Floats

    @property
    def count(self) -> int:
        """How many regressors."""
        return self.precision.size

    @functools.cached_property
    def _of_all_joints(self) -> tuple[Floats, Floats]:
        # The equations of every block, its joints taken together.
        return self.gram.sum(axis=0), self.moment.sum(axis=0)

    def strengths(self, training: NDArray[np.bool_]) -> Floats:
        """Return the strengths (p,) fitted on the blocks marked in ``training`` (blocks,)."""
        gram, moment = (own[training].sum(axis=0) for own in self._of_all_joints)
        return _solve(gram + np.diag(self.precision), moment)

    def errors(self, strengths: Floats, blocks: NDArray[np.bool_]) -> Floats:
        """Return the squared error (joints, those blocks) left by given strengths."""
        power, moment, gram = (own[:, blocks] for own in (self.power, self.moment, self.gram))
        return np.asarray(power - 2.0 * moment @ strengths + (gram @ strengths) @ strengths)

    def heldout_errors(self, folds: list[NDArray[np.bool_]]) -> Floats:
        """Return the squared error (joints, blocks), each block predicted by a fit that has not seen it."""
        out = np.empty_like(self.power)
        for fold in folds:
            out[:, fold] = self.errors(self.strengths(~fold), fold)
        return out

    def covariance(self, strengths: Floats, groups: Integers) -> Floats:
        """Return the covariance (p, p) of strengths fitted on all blocks.

        It is the clustered sandwich: the score of each group of blocks (``groups`` (blocks,) numbers them) stands for
        itself, so that noise coloured or uneven within groups is accounted for whatever its form (Liang and Zeger,
        Biometrika 73, 1986), with the small-sample factor groups/(groups − 1).
        """
        gram, moment = self._of_all_joints
        inverse = self._inverse
        by_block = moment - gram @ strengths
        count = int(groups[-1]) + 1
        score = np.zeros((count, self.count))
        np.add.at(score, groups, by_block)
        return np.asarray(inverse @ (score.T @ score) @ inverse * (count / (count - 1.0)))

    def white_covariance(self, variance: Floats | None = None) -> Floats:
        """Return the covariance (p, p) of the strengths if a joint's weighted rows carry white noise of ``variance``
        (joints,), by default of 1.
        """
        inverse = self._inverse
        if variance is None:
            return inverse
        noisy = np.einsum("j,jpq->pq", variance, self.gram.sum(axis=1)) + np.diag(self.precision)
        return np.asarray(inverse @ noisy @ inverse)

    @functools.cached_property
    def _inverse(self) -> Floats:
        return _solve(self._of_all_joints[0].sum(axis=0) + np.diag(self.precision), np.eye(self.count))

    def without(self, columns: list[int]) -> Normal:
        """Return the equations with some regressors left out."""
        kept = [i for i in range(self.count) if i not in set(columns)]
        gram = self.gram[:, :, kept][:, :, :, kept]
        return Normal(gram, self.moment[:, :, kept], self.power, self.precision[kept])

    def kept_within(self, place: slice, reach: Floats) -> Normal:
        """Return the equations with what is known beforehand of some strengths drawn tighter, so that they stay within.

        ``place`` are those strengths, ``reach`` (k,) how far from zero each may go.
        """
        out, everything = self, np.ones(self.power.shape[1], dtype=bool)
        for _ in range(MOST_TIGHTER):
            over = np.abs(out.strengths(everything)[place]) / reach
            if not np.any(over > WITHIN):
                break
            precision = out.precision.copy()
            precision[place] *= np.maximum(over, 1.0) ** 2
            out = replace(out, precision=precision)
        return out


def _scaled(gram: Floats) -> tuple[Floats, Floats]:
    # Columns differ in unit; scaling to unit diagonal makes the relative floor on it mean the same for all.
    # A regressor without any data (a joint that never moves) gets no strength.
    diagonal = np.diag(gram)
    alive = diagonal > 1e-200
    scale = np.where(alive, 1.0 / np.sqrt(np.where(alive, diagonal, 1.0)), 0.0)
    scaled = gram * scale[:, None] * scale[None, :]
    scaled[np.diag_indices_from(scaled)] += np.where(alive, 1e-10, 1.0)
    return scaled, scale


def _whitening(gram: Floats) -> Floats:
    # W (p, p) with WᵀW the inverse that _solve applies.
    scaled, scale = _scaled(gram)
    return np.asarray(solve_triangular(cholesky(scaled, lower=True), np.diag(scale), lower=True))


def _solve(gram: Floats, right: Floats) -> Floats:
    scaled, scale = _scaled(gram)
    factor = cho_factor(scaled)
    if right.ndim == 1:
        return np.asarray(scale * cho_solve(factor, scale * right))
    return np.asarray(scale[:, None] * cho_solve(factor, scale[:, None] * right))


class System:
    """Rows with the regressors that are in the model so far; further ones can be tried against it.

    ``felt`` holds, for each joint, which of all regressors it feels, and ``base`` these, weighted, (rows, felt).
    """

    def __init__(self, rows: Rows, columns: list[Columns], precisions: list[Floats]) -> None:
        """Set up the equations; ``precisions`` holds one array (k,) for each block of columns."""
        self.rows = rows
        precision = np.concatenate(precisions) if precisions else np.empty(0)
        self.count = precision.size
        # A joint feels few of all regressors: only those that it does are kept, weighted.
        felt = [_joint_columns(rows, columns, precisions, joint) for joint in range(rows.joints)]
        self.felt = [place for place, _ in felt]
        self.base = [own * rows.weight[:, [joint]] for joint, (_, own) in enumerate(felt)]
        self.target = rows.target * rows.weight
        parts = [self._products_of(joint) for joint in range(rows.joints)]
        gram, moment, power = (np.stack(of_joints) for of_joints in zip(*parts, strict=True))
        self.normal = Normal(gram, moment, power, precision)

    def _products_of(self, joint: int) -> tuple[Floats, Floats, Floats]:
        base, felt, target = self.base[joint], self.felt[joint], self.target[:, [joint]]
        gram = np.zeros((self.rows.blocks, self.count, self.count))
        moment = np.zeros((self.rows.blocks, self.count))
        gram[:, felt[:, None], felt] = self.rows.products(base, base)
        moment[:, felt] = self.rows.products(base, target)[:, :, 0]
        return gram, moment, self.rows.products(target, target)[:, 0, 0]

    def reweighted(self, weight: Floats, joints: Iterable[int]) -> System:
        """Return the system with the rows of some ``joints`` counted by another ``weight`` (rows, joints)."""
        out = copy(self)
        out.__dict__.pop("_kept", None)
        whole = self.rows.weight.copy()
        out.base, out.target = list(self.base), self.target.copy()
        gram, moment, power = self.normal.gram.copy(), self.normal.moment.copy(), self.normal.power.copy()
        for joint in joints:
            before = self.rows.weight[:, joint]
            change = np.divide(weight[:, joint], before, out=np.zeros_like(before), where=before > 0.0)
            whole[:, joint] = weight[:, joint]
            out.base[joint] = self.base[joint] * change[:, None]
            out.target[:, joint] = self.rows.target[:, joint] * weight[:, joint]
            gram[joint], moment[joint], power[joint] = out._products_of(joint)
        out.rows = replace(self.rows, weight=whole)
        out.normal = Normal(gram, moment, power, self.normal.precision)
        return out

    def kept_within(self, place: slice, reach: Floats) -> System:
        """Return the system with some strengths kept within their reach, as those of its equations are."""
        kept = copy(self)
        kept.normal = self.normal.kept_within(place, reach)
        kept.__dict__.pop("_kept", None)  # what was screened by is of the equations as they were
        return kept

    def residual(self, strengths: Floats) -> Floats:
        """Return what given strengths leave of the target, unweighted, (rows, joints); 0 where nothing is measured."""
        pairs = zip(self.base, self.felt, strict=True)
        left = np.column_stack([self.target[:, j] - base @ strengths[felt] for j, (base, felt) in enumerate(pairs)])
        weight = self.rows.weight
        return np.divide(left, weight, out=np.zeros_like(left), where=weight > 0.0)

    def screen(self, block: Columns, every: int = 1) -> tuple[Floats, Floats]:
        """Try many candidates of one kind at once.

        ``block`` holds, for each joint, the columns (rows/every, K, k) of K candidates of k strengths each; with
        ``every`` above 1, each ``every``-th row stands for all.  Returns their
        strengths (K, k) and gains (K,): by how much each lowers the weighted squared error, fitted together with
        everything in the model.
        """
        _, number, count = next(iter(block.values())).shape
        cross = np.zeros((self.normal.count, number * count))
        own = np.zeros((number, count, count))
        moment = np.zeros((number, count))
        for joint, columns in block.items():
            weighted = columns * self.rows.weight[::every, joint, None, None] * np.sqrt(every)
            flat = weighted.reshape(weighted.shape[0], -1)
            cross[self.felt[joint]] += np.sqrt(every) * self.base[joint][::every].T @ flat
            own += np.einsum("nki,nkj->kij", weighted, weighted, optimize=True)
            moment += np.sqrt(every) * (self.target[::every, joint] @ flat).reshape(number, count)
        whitening, fitted = self._thinned(every)
        held = (whitening @ cross).reshape(-1, number, count).transpose(1, 2, 0)
        reduced = own - np.einsum("kip,kjp->kij", held, held, optimize=True)
        score = moment - (fitted @ cross).reshape(number, count)
        # A column that the model holds already, or that the motion does not show, is left without strength rather than
        # divided by nothing.
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
        # What whitens the model's regressors, and its strengths, on the rows that candidates are screened on: on
        # others, what it nearly holds would be lost in a difference, and what it leaves would look like more.
        if every not in self._kept:
            gram, moment = np.diag(self.normal.precision), np.zeros(self.normal.count)
            for joint, (base, felt) in enumerate(zip(self.base, self.felt, strict=True)):
                thin = base[::every]
                gram[np.ix_(felt, felt)] += every * thin.T @ thin
                moment[felt] += every * thin.T @ self.target[::every, joint]
            self._kept[every] = _whitening(gram), _solve(gram, moment)
        return self._kept[every]

    @functools.cached_property
    def _kept(self) -> dict[int, tuple[Floats, Floats]]:
        return {}

    def extended(self, candidate: Columns, precision: Floats) -> Normal:
        """Return the normal equations with a candidate's columns added at the end."""
        old, count = self.normal, precision.size
        joints, blocks, width = old.moment.shape
        gram = np.zeros((joints, blocks, width + count, width + count))
        moment = np.zeros((joints, blocks, width + count))
        gram[:, :, :width, :width] = old.gram
        moment[:, :, :width] = old.moment
        for joint, columns in candidate.items():
            weighted = columns * self.rows.weight[:, [joint]]
            cross = np.zeros((blocks, width, count))
            cross[:, self.felt[joint]] = self.rows.products(self.base[joint], weighted)
            gram[joint, :, :width, width:] = cross
            gram[joint, :, width:, :width] = np.swapaxes(cross, 1, 2)
            gram[joint, :, width:, width:] = self.rows.products(weighted, weighted)
            moment[joint, :, width:] = self.rows.products(weighted, self.target[:, [joint]])[:, :, 0]
        return Normal(gram, moment, old.power, np.concatenate([old.precision, precision]))


def _joint_columns(rows: Rows, blocks: list[Columns], precisions: list[Floats], joint: int) -> tuple[Integers, Floats]:
    # Which of all regressors a joint feels, and these, (rows, felt).
    places, parts, end = [np.empty(0, dtype=np.int64)], [np.empty((rows.block.size, 0))], 0
    for block, precision in zip(blocks, precisions, strict=True):
        start, end = end, end + precision.size
        if joint in block:
            shown = np.any(block[joint], axis=0)
            places.append(start + np.flatnonzero(shown))
            parts.append(block[joint][:, shown])
    return np.concatenate(places), np.concatenate(parts, axis=1)
