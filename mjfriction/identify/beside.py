"""What is unknown at a joint beside its friction, and what the other joints say about it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from mjfriction.identify.regression import System
from mjfriction.record.log import Floats

# Floor of the eigenvalues, as a share of the largest: a combination known less than this counts as unknown.
LEAST = 1e-10


@dataclass(frozen=True)
class Beside:
    """Regressors ``columns`` (rows, k) that a joint's friction is fitted together with.

    They are rotated so that the prior of their strengths is independent: mean ``expected`` (k,), with a ``precision``
    each.
    """

    columns: Floats
    expected: Floats
    precision: Floats


@dataclass(frozen=True)
class FreeOf:
    """Projects out of weighted rows what regressors explain equally well (Frisch and Waugh, Econometrica 1, 1933).

    Their prior is appended below the rows as ``known`` (k,); ``basis`` (rows + k, k) spans both.
    """

    known: Floats
    basis: Floats

    def target(self, rows: Floats) -> Floats:
        """Return a weighted target (rows,) with the regressors projected out, (rows + k,)."""
        return self._without(np.concatenate([rows, self.known]))

    def columns(self, rows: Floats) -> Floats:
        """Return weighted columns (rows, m) with the regressors projected out, (rows + k, m)."""
        return self._without(np.vstack([rows, np.zeros((self.known.size, rows.shape[1]))]))

    def _without(self, whole: Floats) -> Floats:
        return np.asarray(whole - self.basis @ (self.basis.T @ whole))


def free_of(beside: Beside, deviation: Floats) -> FreeOf:
    """Return the projection for rows with a standard ``deviation`` (rows,)."""
    root = np.sqrt(beside.precision)
    whole = np.vstack([beside.columns / deviation[:, None], np.diag(root)])
    return FreeOf(root * beside.expected, np.linalg.qr(whole)[0])


def beside_of(system: System, joint: int, shared: int, strengths: Floats) -> Beside:
    """Return what is unknown at a joint beside its friction, relative to given ``strengths`` (p,) of the system.

    The first ``shared`` regressors of ``system`` act on many joints; the rest are friction, each of one joint.
    """
    normal = system.normal
    gram, moment = normal.products.of_joints([other for other in range(normal.joints) if other != joint])
    gram += np.diag(normal.precision)
    moment -= gram @ strengths
    friction = np.flatnonzero(np.diag(gram)[shared:] > 0.0) + shared
    known, told = gram[:shared, :shared], moment[:shared]
    if friction.size:
        # Eliminate the other joints' friction, which is as free as this joint's.
        factor = cho_factor(gram[np.ix_(friction, friction)])
        across = gram[:shared, friction]
        known = known - across @ cho_solve(factor, across.T)
        told = told - across @ cho_solve(factor, moment[friction])
    scale = 1.0 / np.sqrt(np.diag(known))
    power, turned = np.linalg.eigh(known * scale[:, None] * scale)
    turned = turned * scale[:, None]
    covariance = (turned / np.maximum(power, LEAST * power.max(initial=0.0))) @ turned.T
    # Regressors that do not act on this joint remain as the other joints determine them.
    of_many = system.felt[joint] < shared
    felt, base, weight = (
        system.felt[joint][of_many],
        system.told[joint][:, :-1][:, of_many],
        system.rows.weight[:, [joint]],
    )
    columns = np.divide(base, weight, out=np.zeros_like(base), where=weight > 0.0)
    own = covariance[np.ix_(felt, felt)]
    size = np.sqrt(np.diag(own))
    power, turned = np.linalg.eigh(own / size[:, None] / size)
    turned = turned * size[:, None]
    power = np.maximum(power, LEAST * power.max(initial=0.0))
    return Beside(
        columns=columns @ turned,
        expected=np.linalg.solve(turned, (covariance @ told)[felt]) if felt.size else np.empty(0),
        precision=1.0 / power,
    )
