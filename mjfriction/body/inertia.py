"""A link's inertia as ten parameters, and as the pseudo-inertia, which shows whether it is physical.

The pseudo-inertia of a link is P = ∫ (x, 1)ᵀ(x, 1) dm, a symmetric 4 × 4 matrix that is linear in the ten inertial
parameters.  A body with these parameters exists if and only if P is positive (Wensing, Kim, Slotine, IEEE Robotics and
Automation Letters 3(1), 2018).

Relative to a link with P₀ = C·Cᵀ, another link is P = C·(1 + W)·Cᵀ with W symmetric.  The ten orthonormal numbers of W
have no unit, and |W| is a distance between the two links that does not depend on the frame (Lee, Wensing, Park, IEEE
Trans. Robotics 36(1), 2020, constant pullback): the same link with p times the mass is at |W| = 2·(p − 1).  A body
exists for W if 1 + W is positive.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from mjfriction.laws.law import Floats

NAMES = ("mass", "moment_x", "moment_y", "moment_z", "xx", "xy", "yy", "xz", "yz", "zz")
"""The ten parameters in the regressor's order: kg, kg·m, and kg·m² about the link's frame."""

PER_LINK = len(NAMES)
FINEST = 0.02  # m, spread added to every link's mass, so that a link stated as a point may be a body of about this size
ROWS, COLUMNS = np.tril_indices(4)
ORTHONORMAL = np.where(ROWS == COLUMNS, 1.0, np.sqrt(0.5))  # factor from each of the ten numbers to its entry of W


@dataclass(frozen=True)
class RigidLink:
    """A link's mass (kg), its centre of mass (m, in the link's frame) and its inertia about that centre (kg·m²).

    The moments are in the order xx, yy, zz, xy, xz, yz.
    """

    mass: float
    com: tuple[float, float, float]
    inertia: tuple[float, float, float, float, float, float]

    def pinocchio(self) -> pin.Inertia:
        """Return it as a Pinocchio inertia."""
        xx, yy, zz, xy, xz, yz = self.inertia
        return pin.Inertia(self.mass, np.array(self.com), np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]))


def pseudo_inertias(model: pin.Model) -> Floats:
    """Return the pseudo-inertias of a model's links, (links, 4, 4)."""
    return np.array([pin.PseudoInertia.FromInertia(inertia).toMatrix() for inertia in list(model.inertias)[1:]])


def factors(pseudo: Floats) -> Floats:
    """Return the factors C (links, 4, 4) of pseudo-inertias (links, 4, 4), zero for links without a mass.

    A pseudo-inertia that no body has (one moment of inertia larger than the sum of the other two) is replaced by the
    nearest one that a body can have.  The mass of every link is then spread by FINEST, so that a point mass has a
    factor too.
    """
    out = np.zeros_like(pseudo)
    for own, factor in zip(pseudo, out, strict=True):
        if own[3, 3] > 0.0:
            factor[:] = np.linalg.cholesky(_spread_out(own) + np.diag([own[3, 3] * FINEST**2] * 3 + [0.0]))
    return out


def _spread_out(pseudo: Floats) -> Floats:
    # The pseudo-inertia (4, 4) with negative spreads of its mass about its centre set to zero.
    mass, first = pseudo[3, 3], pseudo[:3, 3]
    values, vectors = np.linalg.eigh(pseudo[:3, :3] - np.outer(first, first) / mass)
    if values[0] >= 0.0:
        return pseudo
    out = pseudo.copy()
    out[:3, :3] = (vectors * np.maximum(values, 0.0)) @ vectors.T + np.outer(first, first) / mass
    return out


def symmetric(numbers: Floats) -> Floats:
    """Return the symmetric matrix W (4, 4) from its ten orthonormal numbers."""
    out = np.zeros((4, 4))
    out[ROWS, COLUMNS] = out[COLUMNS, ROWS] = ORTHONORMAL * numbers
    return out


def parameters_per_number(factor: Floats) -> Floats:
    """Return the derivatives of the inertial parameters by W's ten numbers, (links, 10, 10); ``factor`` is C."""
    unit = [symmetric(row) for row in np.eye(PER_LINK)]
    return np.array([np.column_stack([parameters_of(own @ one @ own.T) for one in unit]) for own in factor])


def link_of(pseudo: Floats) -> RigidLink:
    """Return the link with the given pseudo-inertia (4, 4)."""
    inertia = pin.PseudoInertia.FromMatrix(pseudo).toInertia()
    moments = inertia.inertia
    six = (moments[0, 0], moments[1, 1], moments[2, 2], moments[0, 1], moments[0, 2], moments[1, 2])
    x, y, z = inertia.lever.tolist()
    xx, yy, zz, xy, xz, yz = (float(value) for value in six)
    return RigidLink(float(inertia.mass), (x, y, z), (xx, yy, zz, xy, xz, yz))


def parameters_of(pseudo: Floats) -> Floats:
    """Return the ten inertial parameters (10,) of a pseudo-inertia (4, 4), linear in it, in the regressor's order."""
    return np.asarray(pin.PseudoInertia.FromMatrix(pseudo).toDynamicParameters())
