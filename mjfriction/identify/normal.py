"""Normal equations, per joint and block of motion.

They give the fit on any set of blocks, its error on the others, and intervals that hold for coloured noise, all without
going back to the rows.
"""

from __future__ import annotations

import functools
from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cholesky, solve_triangular

from mjfriction.record.log import Floats, Integers

WITHIN = 1.05  # a strength may go beyond its reach by this factor
MOST_TIGHTER = 20  # how many times a prior is tightened at most


@dataclass(frozen=True)
class Part:
    """The products of one joint's weighted rows, in each block.

    ``felt`` (f,) are the indices of the regressors that act on the joint; ``gram`` (blocks, f, f) their products with
    one another, ``moment`` (blocks, f) with the target, ``power`` (blocks,) the target's with itself.
    """

    felt: Integers
    gram: Floats
    moment: Floats
    power: Floats

    @functools.cached_property
    def of_all_blocks(self) -> tuple[Floats, Floats, float]:
        """The sums of gram (f, f), moment (f,) and power over the blocks."""
        return self.gram.sum(axis=0), self.moment.sum(axis=0), float(self.power.sum())

    def errors(self, strengths: Floats) -> Floats:
        """Return the squared error (blocks,) that the strengths given for each block (blocks, p) leave there."""
        own = strengths[:, self.felt]
        bent = np.matmul(self.gram, own[..., None])[..., 0]
        return np.asarray(self.power + np.sum((bent - 2.0 * self.moment) * own, axis=1))

    def error(self, strengths: Floats) -> float:
        """Return the squared error that strengths (p,) leave on all blocks."""
        gram, moment, power = self.of_all_blocks
        own = strengths[self.felt]
        return float(power + (gram @ own - 2.0 * moment) @ own)

    def of(self, kept: Integers) -> Part:
        """Return the part with only the regressors ``kept``, renumbered in that order."""
        place = np.full(max(int(np.max(self.felt, initial=0)), int(np.max(kept, initial=0))) + 1, -1)
        place[kept] = np.arange(kept.size)
        own = np.flatnonzero(place[self.felt] >= 0)
        return Part(place[self.felt[own]], self.gram[:, own[:, None], own], self.moment[:, own], self.power)


@dataclass(frozen=True)
class Products:
    """The ``parts`` of all joints, for ``count`` regressors in total."""

    parts: tuple[Part, ...]
    count: int

    @functools.cached_property
    def of_blocks(self) -> tuple[Floats, Floats]:
        """Gram (blocks, p, p) and moment (blocks, p) of each block, summed over its joints."""
        blocks = self.parts[0].power.size
        gram, moment = np.zeros((blocks, self.count, self.count)), np.zeros((blocks, self.count))
        for part in self.parts:
            gram[:, part.felt[:, None], part.felt] += part.gram
            moment[:, part.felt] += part.moment
        return gram, moment

    @functools.cached_property
    def whole(self) -> tuple[Floats, Floats]:
        """Gram (p, p) and moment (p,), summed over all blocks and joints."""
        gram, moment = self.of_blocks
        return gram.sum(axis=0), moment.sum(axis=0)

    def of_joints(self, joints: Collection[int]) -> tuple[Floats, Floats]:
        """Return gram (p, p) and moment (p,), summed over all blocks of some joints."""
        gram, moment = np.zeros((self.count, self.count)), np.zeros(self.count)
        for joint in joints:
            part = self.parts[joint]
            own, told, _ = part.of_all_blocks
            gram[part.felt[:, None], part.felt] += own
            moment[part.felt] += told
        return gram, moment

    def extended(self, more: dict[int, Part], count: int) -> Products:
        """Return the products with ``count`` more regressors at the end.

        ``more`` holds the complete parts of the joints that these act on.
        """
        out = Products(tuple(more.get(joint, part) for joint, part in enumerate(self.parts)), self.count + count)
        # The sums of the blocks are known, except for the new rows and columns.
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
    """Normal equations: ``products`` of the rows, and the prior.

    ``precision`` (p,) is one over the prior variance of each strength, 0 where there is no prior.
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
        """The weighted squared target, (joints, blocks)."""
        return np.stack([part.power for part in self.products.parts])

    @functools.cached_property
    def fitted(self) -> Floats:
        """The strengths (p,) fitted on all blocks."""
        gram, moment = self.equations()
        return solved(gram, moment)

    def equations(self, training: NDArray[np.bool_] | None = None) -> tuple[Floats, Floats]:
        """Return the matrix (p, p) and the right side (p,) to solve for some blocks of all joints, with the prior.

        ``training`` (blocks,) marks the blocks, all by default.  Several such marks (k, blocks) give k of each.
        """
        if training is None:
            gram, moment = self.products.whole
        else:
            marked = training.astype(np.float64)
            gram, moment = (np.tensordot(marked, own, axes=1) for own in self.products.of_blocks)
        return gram + np.diag(self.precision), moment

    def strengths(self, training: NDArray[np.bool_]) -> Floats:
        """Return the strengths (p,) fitted on the blocks marked in ``training`` (blocks,).

        Several such marks (k, blocks) give (k, p).
        """
        return solved(*self.equations(training))

    def error(self, strengths: Floats) -> Floats:
        """Return the squared error (joints,) that given strengths leave on all blocks."""
        return np.array([part.error(strengths) for part in self.products.parts])

    def heldout_errors(self, folds: Sequence[NDArray[np.bool_]]) -> Floats:
        """Return the squared error (joints, blocks), each block predicted by a fit that has not seen it.

        A block in no fold is predicted with zero strengths, that is, by what is stated.
        """
        parts, left_out = self.products.parts, np.array(folds)
        strengths = np.zeros((parts[0].power.size, self.count))
        for fold, own in zip(folds, self.strengths(~left_out), strict=True):
            strengths[fold] = own
        return np.stack([part.errors(strengths) for part in parts])

    def covariance(self, groups: Integers) -> Floats:
        """Return the covariance (p, p) of the strengths fitted on all blocks.

        It is the clustered sandwich estimate: the score of each group of blocks (``groups`` (blocks,) numbers them)
        counts as one observation, so that noise that is coloured or uneven within groups is accounted for whatever its
        form (Liang and Zeger, Biometrika 73, 1986).  It includes the small-sample factor groups/(groups − 1).
        """
        gram, moment = self.products.of_blocks
        inverse = self._inverse
        by_block = moment - gram @ self.fitted
        count = int(groups[-1]) + 1
        score = np.zeros((count, self.count))
        np.add.at(score, groups, by_block)
        return np.asarray(inverse @ (score.T @ score) @ inverse.T * (count / (count - 1.0)))

    def white_covariance(self, variance: Floats) -> Floats:
        """Return the covariance (p, p) of the strengths if the weighted rows of each joint carry white noise.

        ``variance`` (joints,) is that of the noise.
        """
        noisy = np.diag(self.precision)
        for part, own in zip(self.products.parts, variance.tolist(), strict=True):
            noisy[part.felt[:, None], part.felt] += own * part.of_all_blocks[0]
        return np.asarray(self._inverse @ noisy @ self._inverse.T)

    def known_to(self, spread: float) -> Floats:
        """Return the covariance (p, p) of the strengths from the prior and rows with white noise of variance
        ``spread``.
        """
        scaled, scale = _scaled(self.products.whole[0] / spread + np.diag(self.precision))
        return np.asarray(scale[:, None] * np.linalg.inv(scaled) * scale)

    @functools.cached_property
    def _inverse(self) -> Floats:
        return self.known_to(1.0)

    def leaning(self, place: slice) -> Floats:
        """Return the covariance (p, p) of all strengths that an error of the prior at ``place`` causes.

        The strengths there are off from the prior's mean by as much as the prior says: C·Λ·C, where C is the inverse of
        the rows' gram and the prior together and Λ the prior precision at ``place``.
        """
        own = self._inverse[:, place]
        return np.asarray(own * self.precision[place] @ own.T)

    def shown(self, place: slice) -> float:
        """Return how many of the strengths at ``place`` are determined by the rows rather than by the prior."""
        return float(np.sum(1.0 - self.precision[place] * np.diag(self._inverse)[place]))

    def tighter(self, place: slice, times: float) -> Normal:
        """Return the equations with the prior of the strengths at ``place`` so many ``times`` as precise."""
        precision = self.precision.copy()
        precision[place] *= times
        return replace(self, precision=precision)

    def without(self, columns: list[int]) -> Normal:
        """Return the equations with some regressors left out."""
        kept = np.array([i for i in range(self.count) if i not in set(columns)], dtype=np.int64)
        parts = tuple(part.of(kept) for part in self.products.parts)
        return Normal(Products(parts, kept.size), self.precision[kept])

    def kept_within(self, place: slice, reach: Floats) -> Normal:
        """Return the equations with the prior of some strengths tightened so that they stay within their reach.

        ``place`` says which strengths, ``reach`` (k,) how far from zero each may go.
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
    # Columns differ in unit.  Scaling the diagonal to 1 gives the relative floor the same meaning for all.  A regressor
    # without any data (a joint that never moves) gets no strength.
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
    """Return gram⁻¹·right, (p,), or (k, p) for k such (p, p); a regressor without data gets zero strength."""
    scaled, scale = _scaled(gram)
    return np.asarray(scale * np.linalg.solve(scaled, (scale * right)[..., None])[..., 0])
