"""Normal equations, per joint and block of motion: the fit on any set of blocks, its error on the others, and intervals
that survive coloured noise, all without going back to the rows.
"""

from __future__ import annotations

import functools
from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cholesky, solve_triangular

from mjfriction.record.log import Floats, Integers

WITHIN = 1.05  # of its reach, that a strength may go to
MOST_TIGHTER = 20  # times that what is known beforehand of it is drawn tighter


@dataclass(frozen=True)
class Part:
    """What one joint's weighted rows come to in each block.

    ``felt`` (f,) are those of all regressors that the joint feels; ``gram`` (blocks, f, f) their products with one
    another, ``moment`` (blocks, f) with the target, ``power`` (blocks,) the target's own.
    """

    felt: Integers
    gram: Floats
    moment: Floats
    power: Floats

    @functools.cached_property
    def of_all_blocks(self) -> tuple[Floats, Floats, float]:
        """The sums over the blocks of gram (f, f), moment (f,) and power."""
        return self.gram.sum(axis=0), self.moment.sum(axis=0), float(self.power.sum())

    def errors(self, strengths: Floats) -> Floats:
        """Return the squared error (blocks,) that strengths of each block (blocks, p) leave."""
        own = strengths[:, self.felt]
        bent = np.matmul(self.gram, own[..., None])[..., 0]
        return np.asarray(self.power + np.sum((bent - 2.0 * self.moment) * own, axis=1))

    def error(self, strengths: Floats) -> float:
        """Return the squared error that strengths (p,) leave on all blocks."""
        gram, moment, power = self.of_all_blocks
        own = strengths[self.felt]
        return float(power + (gram @ own - 2.0 * moment) @ own)

    def of(self, kept: Integers) -> Part:
        """Return the part of those regressors only that are ``kept``, numbered anew in that order."""
        place = np.full(max(int(np.max(self.felt, initial=0)), int(np.max(kept, initial=0))) + 1, -1)
        place[kept] = np.arange(kept.size)
        own = np.flatnonzero(place[self.felt] >= 0)
        return Part(place[self.felt[own]], self.gram[:, own[:, None], own], self.moment[:, own], self.power)


@dataclass(frozen=True)
class Products:
    """The ``parts`` of all joints, of ``count`` regressors together."""

    parts: tuple[Part, ...]
    count: int

    @functools.cached_property
    def of_blocks(self) -> tuple[Floats, Floats]:
        """Gram (blocks, p, p) and moment (blocks, p) of each block, its joints taken together."""
        blocks = self.parts[0].power.size
        gram, moment = np.zeros((blocks, self.count, self.count)), np.zeros((blocks, self.count))
        for part in self.parts:
            gram[:, part.felt[:, None], part.felt] += part.gram
            moment[:, part.felt] += part.moment
        return gram, moment

    @functools.cached_property
    def whole(self) -> tuple[Floats, Floats]:
        """Gram (p, p) and moment (p,) of all blocks and joints."""
        gram, moment = self.of_blocks
        return gram.sum(axis=0), moment.sum(axis=0)

    def of_joints(self, joints: Collection[int]) -> tuple[Floats, Floats]:
        """Return gram (p, p) and moment (p,) of all blocks of some joints."""
        gram, moment = np.zeros((self.count, self.count)), np.zeros(self.count)
        for joint in joints:
            part = self.parts[joint]
            own, told, _ = part.of_all_blocks
            gram[part.felt[:, None], part.felt] += own
            moment[part.felt] += told
        return gram, moment

    def extended(self, more: dict[int, Part], count: int) -> Products:
        """Return the products with ``count`` more regressors at the end; ``more`` are the parts, in full, of the joints
        that feel these.
        """
        out = Products(tuple(more.get(joint, part) for joint, part in enumerate(self.parts)), self.count + count)
        # What the blocks come to is known but for the new rows and columns.
        gram, moment = self.of_blocks
        whole = np.zeros((gram.shape[0], out.count, out.count))
        whole[:, : self.count, : self.count] = gram
        told = np.concatenate([moment, np.zeros((gram.shape[0], count))], axis=1)
        new = np.arange(self.count, out.count)
        for part in more.values():
            cross = part.gram[:, :, -count:]
            whole[:, part.felt[:, None], new] += cross
            told[:, new] += part.moment[:, -count:]
        whole[:, self.count :, : self.count] = np.swapaxes(whole[:, : self.count, self.count :], 1, 2)
        out.__dict__["of_blocks"] = whole, told
        return out


@dataclass(frozen=True)
class Normal:
    """Normal equations: ``products`` of the rows, and ``precision`` (p,), one over the prior variance of each strength,
    0 where nothing is known beforehand.
    """

    products: Products
    precision: Floats

    @property
    def count(self) -> int:
        """How many regressors."""
        return self.precision.size

    @property
    def joints(self) -> int:
        """How many joints."""
        return len(self.products.parts)

    @property
    def power(self) -> Floats:
        """What there was to explain, squared and weighted, (joints, blocks)."""
        return np.stack([part.power for part in self.products.parts])

    @functools.cached_property
    def fitted(self) -> Floats:
        """The strengths (p,) fitted on all blocks."""
        gram, moment = self.equations()
        return solved(gram, moment)

    def equations(self, training: NDArray[np.bool_] | None = None) -> tuple[Floats, Floats]:
        """Return what is to be solved, (p, p) and (p,): that of all joints on the blocks marked in ``training``
        (blocks,), by default on all, with what is known beforehand.  Of several such marks (k, blocks), as many.
        """
        if training is None:
            gram, moment = self.products.whole
        else:
            marked = training.astype(np.float64)
            gram, moment = (np.tensordot(marked, own, axes=1) for own in self.products.of_blocks)
        return gram + np.diag(self.precision), moment

    def strengths(self, training: NDArray[np.bool_]) -> Floats:
        """Return the strengths (p,) fitted on the blocks marked in ``training`` (blocks,); of several such marks
        (k, blocks), (k, p).
        """
        return solved(*self.equations(training))

    def error(self, strengths: Floats) -> Floats:
        """Return the squared error (joints,) that given strengths leave on all blocks."""
        return np.array([part.error(strengths) for part in self.products.parts])

    def heldout_errors(self, folds: Sequence[NDArray[np.bool_]]) -> Floats:
        """Return the squared error (joints, blocks), each block predicted by a fit that has not seen it; one that is in
        no fold by what is stated.
        """
        parts, left_out = self.products.parts, np.array(folds)
        strengths = np.zeros((parts[0].power.size, self.count))
        for fold, own in zip(folds, self.strengths(~left_out), strict=True):
            strengths[fold] = own
        return np.stack([part.errors(strengths) for part in parts])

    def covariance(self, groups: Integers) -> Floats:
        """Return the covariance (p, p) of the strengths fitted on all blocks.

        It is the clustered sandwich: the score of each group of blocks (``groups`` (blocks,) numbers them) stands for
        itself, so that noise coloured or uneven within groups is accounted for whatever its form (Liang and Zeger,
        Biometrika 73, 1986), with the small-sample factor groups/(groups − 1).
        """
        gram, moment = self.products.of_blocks
        inverse = self._inverse
        by_block = moment - gram @ self.fitted
        count = int(groups[-1]) + 1
        score = np.zeros((count, self.count))
        np.add.at(score, groups, by_block)
        return np.asarray(inverse @ (score.T @ score) @ inverse.T * (count / (count - 1.0)))

    def white_covariance(self, variance: Floats) -> Floats:
        """Return the covariance (p, p) of the strengths if a joint's weighted rows carry white noise of ``variance``
        (joints,).
        """
        noisy = np.diag(self.precision)
        for part, own in zip(self.products.parts, variance.tolist(), strict=True):
            noisy[part.felt[:, None], part.felt] += own * part.of_all_blocks[0]
        return np.asarray(self._inverse @ noisy @ self._inverse.T)

    def known_to(self, spread: float) -> Floats:
        """Return the covariance (p, p) of strengths that rows with white noise of variance ``spread`` and what is known
        beforehand leave.
        """
        scaled, scale = _scaled(self.products.whole[0] / spread + np.diag(self.precision))
        return np.asarray(scale[:, None] * np.linalg.inv(scaled) * scale)

    @functools.cached_property
    def _inverse(self) -> Floats:
        return self.known_to(1.0)

    def leaning(self, place: slice) -> Floats:
        """Return the covariance (p, p) that all strengths have since those at ``place`` are off from what is known
        beforehand by as much as that says: C·Λ·C, of the rows' and the knowledge's inverse C, Λ being their precision.
        """
        own = self._inverse[:, place]
        return np.asarray(own * self.precision[place] @ own.T)

    def shown(self, place: slice) -> float:
        """Return how many of the strengths at ``place`` the rows show, rather than what is known beforehand."""
        return float(np.sum(1.0 - self.precision[place] * np.diag(self._inverse)[place]))

    def tighter(self, place: slice, times: float) -> Normal:
        """Return the equations with what is known beforehand of the strengths at ``place`` so many times as precise."""
        precision = self.precision.copy()
        precision[place] *= times
        return replace(self, precision=precision)

    def without(self, columns: list[int]) -> Normal:
        """Return the equations with some regressors left out."""
        kept = np.array([i for i in range(self.count) if i not in set(columns)], dtype=np.int64)
        parts = tuple(part.of(kept) for part in self.products.parts)
        return Normal(Products(parts, kept.size), self.precision[kept])

    def kept_within(self, place: slice, reach: Floats) -> Normal:
        """Return the equations with what is known beforehand of some strengths drawn tighter, so that they stay within.

        ``place`` are those strengths, ``reach`` (k,) how far from zero each may go.
        """
        out = self
        for _ in range(MOST_TIGHTER):
            over = np.abs(out.fitted[place]) / reach
            if not np.any(over > WITHIN):
                break
            precision = out.precision.copy()
            precision[place] *= np.maximum(over, 1.0) ** 2
            out = replace(out, precision=precision)
        return out


def _scaled(gram: Floats) -> tuple[Floats, Floats]:
    # Columns differ in unit; scaling to unit diagonal makes the relative floor on it mean the same for all.
    # A regressor without any data (a joint that never moves) gets no strength.
    diagonal = np.diagonal(gram, axis1=-2, axis2=-1)
    if not np.all(np.isfinite(diagonal)):
        raise FloatingPointError("normal equations that are not finite: a regressor is not")
    alive = diagonal > 1e-200
    scale = np.where(alive, 1.0 / np.sqrt(np.where(alive, diagonal, 1.0)), 0.0)
    scaled = gram * scale[..., :, None] * scale[..., None, :]
    np.einsum("...ii->...i", scaled)[...] += np.where(alive, 1e-10, 1.0)
    return scaled, scale


def whitening(gram: Floats) -> Floats:
    """Return W (p, p) with WᵀW the inverse that :func:`solved` applies."""
    scaled, scale = _scaled(gram)
    return np.asarray(solve_triangular(cholesky(scaled, lower=True), np.diag(scale), lower=True))


def solved(gram: Floats, right: Floats) -> Floats:
    """Return gram⁻¹·right, (p,), or (k, p) of k such (p, p); a regressor of which nothing is known has no strength."""
    scaled, scale = _scaled(gram)
    return np.asarray(scale * np.linalg.solve(scaled, (scale * right)[..., None])[..., 0])
