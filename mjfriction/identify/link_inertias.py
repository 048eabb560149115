"""The links' inertias as unknowns of a fit: ten numbers per link, held near what is stated, and always physical.

The numbers are those of W in P = C·(R + W)·Cᵀ (:mod:`mjfriction.body.inertia`), where R is the stated link in these
units: 1, except for links that are stated to be implausibly thin.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_factor, cho_solve
from scipy.optimize import least_squares

from mjfriction.body.inertia import (
    COLUMNS,
    ORTHONORMAL,
    PER_LINK,
    ROWS,
    factors,
    link_of,
    parameters_of,
    parameters_per_number,
    pseudo_inertias,
    symmetric,
)
from mjfriction.body.regressor import weighed_links
from mjfriction.identify.base_parameters import base_parameters
from mjfriction.identify.fitted import Fitted
from mjfriction.identify.gap import Gap
from mjfriction.identify.regression import Columns
from mjfriction.record.log import Floats
from mjfriction.robot.body_tables import LinkInertia
from mjfriction.robot.robot import Robot

KEPT = "inertias of all links"
FELT = 1e-6  # share of the effort below which a link is left out
THINNEST = 1e-3  # of what is stated: the least spread of mass that a fit may leave along any direction
PRECISELY, MOST_ROUNDS = 1e-9, 200  # tolerance and rounds of the search for the nearest physical links


@dataclass(frozen=True)
class LinkInertias:
    """The inertias of the links ``names``, ten strengths for each, one link after another.

    ``factor`` (links, 4, 4) are their C, ``stated`` (links, 4, 4) their R.  ``weight`` (links, 10, 10) is the change of
    the inertial parameters per strength, ``columns`` that of the effort, joint → (rows, 10·links).  ``spread`` is how
    far off links usually are.
    """

    names: tuple[str, ...]
    factor: Floats
    stated: Floats
    weight: Floats
    columns: Columns
    spread: float

    @property
    def precision(self) -> Floats:
        """The prior precision, from how far off stated links usually are."""
        return np.full(PER_LINK * len(self.names), self.spread**-2.0)

    def applied(self, robot: Robot, strengths: Floats) -> Robot:
        """Return the robot with the links changed; one that is not physical is moved to the nearest one that is."""
        body = robot.body()
        now = dict(zip(body.links, pseudo_inertias(body.model), strict=True))
        table = robot.table
        inertia, scale, shift = dict(table.link_inertia), dict(table.link_scale), dict(table.link_shift)
        payload = table.payload
        for name, factor, own in zip(self.names, self.factor, strengths.reshape(-1, PER_LINK), strict=True):
            if not np.any(own):
                continue
            inverse = np.linalg.inv(factor)
            relative = inverse @ now[name] @ inverse.T + symmetric(own)
            link = link_of(factor @ _positive(relative) @ factor.T)
            inertia[name] = LinkInertia(mass=link.mass, com=link.com, inertia=link.inertia)
            scale.pop(name, None)
            shift.pop(name, None)
            if payload is not None and body.link_holding(payload.parent) == name:
                payload = None  # the link includes it now
        changed = {"link_inertia": inertia, "link_scale": scale, "link_shift": shift, "payload": payload}
        return Robot(table.model_copy(update=changed), robot.folder)

    def fitted(self, robot: Robot, gram: Floats, covariance: Floats, quantile: float) -> list[Fitted]:
        """Return the base parameters that the motion shows."""
        body = robot.body()
        now = dict(zip(body.links, pseudo_inertias(body.model), strict=True))
        values = np.concatenate([parameters_of(now[name]) for name in self.names])
        pseudo = self.factor @ self.stated @ np.swapaxes(self.factor, 1, 2)
        stated = np.concatenate([parameters_of(own) for own in pseudo])
        return base_parameters(self.names, values, stated, self.weight, gram, covariance, quantile)

    def physical(self, strengths: Floats) -> bool:
        """Return whether the links are physical when changed by these strengths."""
        changes = [symmetric(own) for own in strengths.reshape(-1, PER_LINK)]
        return bool(np.all(np.linalg.eigvalsh(self.stated + changes) >= THINNEST))


def link_inertias(gap: Gap, spread: float) -> LinkInertias | None:
    """Return the inertias of all links that affect the efforts along a gap's motion, None where none does."""
    body, linked = gap.body, gap.linked
    pseudo = pseudo_inertias(body.model)
    factor = factors(pseudo)
    weight = parameters_per_number(factor)

    def torques(own: slice) -> Floats:
        return weighed_links(body, linked.position[own], linked.velocity[own], linked.acceleration[own], weight)

    rows = gap.kept.recall(KEPT, lambda: gap.rows_of(torques))
    size = float(np.sqrt(np.mean(np.square(np.nan_to_num(gap.measured)))))
    felt = [k for k in range(len(body.links)) if any(np.max(np.abs(own[:, k])) > FELT * size for own in rows.values())]
    if not felt:
        return None
    columns = {joint: own[:, felt].reshape(own.shape[0], -1) for joint, own in rows.items()}
    inverse = np.linalg.inv(factor[felt])
    stated = inverse @ pseudo[felt] @ np.swapaxes(inverse, 1, 2)
    return LinkInertias(tuple(body.links[k] for k in felt), factor[felt], stated, weight[felt], columns, spread)


def nearest_physical(gram: Floats, moment: Floats, place: slice, stated: Floats) -> Floats:
    """Return the strengths (p,) that minimise ½·sᵀGs − mᵀs with physical links at ``place``.

    Links are parametrised as R + W = L·Lᵀ, L lower triangular with logarithms on its diagonal (Rucker, Wensing, IEEE
    Robotics and Automation Letters 7(2), 2022).  ``gram`` (p, p) is positive definite; ``stated`` (links, 4, 4) are the
    R.
    """
    scale = 1.0 / np.sqrt(np.diag(gram))
    root = np.linalg.cholesky(gram * scale[:, None] * scale).T
    target = np.linalg.solve(root.T, moment * scale)
    inside = np.arange(gram.shape[0])[place]
    rest = np.setdiff1d(np.arange(gram.shape[0]), inside)
    own, beside = root[:, inside] / scale[inside], root[:, rest]
    # Eliminate the unconstrained strengths: project residuals onto what no value of these takes away.
    basis = np.linalg.qr(beside)[0] if rest.size else np.zeros((gram.shape[0], 0))
    free_of = own - basis @ (basis.T @ own)
    goal = target - basis @ (basis.T @ target)

    def strengths_at(x: Floats) -> tuple[Floats, Floats]:
        return _from_logarithms(x.reshape(-1, PER_LINK), stated)

    def slopes_at(x: Floats) -> Floats:
        each = free_of.reshape(free_of.shape[0], -1, PER_LINK)
        return np.asarray(np.einsum("rlm,lmk->rlk", each, strengths_at(x)[1]).reshape(free_of.shape))

    found = least_squares(
        lambda x: free_of @ strengths_at(x)[0].ravel() - goal,
        np.concatenate([_to_logarithms(_positive(own)) for own in stated]),
        jac=slopes_at,
        ftol=PRECISELY,
        xtol=PRECISELY,
        max_nfev=MOST_ROUNDS,
    )
    out = np.zeros(gram.shape[0])
    out[inside] = strengths_at(found.x)[0].ravel()
    if rest.size:
        left = moment[rest] - gram[np.ix_(rest, inside)] @ out[inside]
        out[rest] = cho_solve(cho_factor(gram[np.ix_(rest, rest)]), left)
    return out


def _positive(relative: Floats) -> Floats:
    values, vectors = np.linalg.eigh(relative)
    return np.asarray((vectors * np.maximum(values, THINNEST)) @ vectors.T)


def _to_logarithms(relative: Floats) -> Floats:
    lower = np.linalg.cholesky(relative)
    on = np.arange(4)
    lower[on, on] = np.log(lower[on, on])
    return np.asarray(lower[ROWS, COLUMNS])


def _from_logarithms(x: Floats, stated: Floats) -> tuple[Floats, Floats]:
    """Return the strengths (links, 10) of R + W = L·Lᵀ and their slopes (links, 10, 10) by L's entries (links, 10).

    The diagonal of L is given as logarithms.
    """
    lower = np.zeros_like(stated)
    lower[:, ROWS, COLUMNS] = x
    on = np.arange(4)
    lower[:, on, on] = np.exp(lower[:, on, on])
    whole = lower @ np.swapaxes(lower, 1, 2) - stated
    # An entry (r, c) of L is in the r-th row and column of the product: d(L·Lᵀ)ᵢⱼ = (δᵢᵣ·Lⱼ꜀ + δⱼᵣ·Lᵢ꜀)·dLᵣ꜀.
    rows, columns = ROWS[:, None], COLUMNS[:, None]
    slopes = (rows == ROWS) * lower[:, columns, COLUMNS] + (columns == ROWS) * lower[:, rows, COLUMNS]
    step = np.where(ROWS == COLUMNS, lower[:, ROWS, COLUMNS], 1.0)
    return whole[:, ROWS, COLUMNS] / ORTHONORMAL, slopes * step[:, None, :] / ORTHONORMAL[:, None]
