"""The torque that a joint's spring demands of its drive along the stroke."""

from __future__ import annotations

import numpy as np
from numpy.polynomial import polynomial

from mjfriction.laws.law import Floats
from mjfriction.robot.schema import Spring

POWERS = ("preload", "stiffness", "quadratic", "cubic")  # the coefficients of a spring, by the power of position


def coefficients(spring: Spring) -> Floats:
    """Return the coefficients of the spring's torque as a polynomial in position, constant first, (4,)."""
    return np.array([getattr(spring, name) for name in POWERS])


def plus(spring: Spring, added: Floats) -> Spring:
    """Return a spring with coefficients added to its own, the constant first, as many as there are."""
    powers = zip(POWERS, coefficients(spring), added, strict=False)
    return spring.model_copy(update={name: float(own + more) for name, own, more in powers})


def spring_along(powers: Floats, position: Floats) -> Floats:
    """Return the torque, N·m or N, that the drive works against at positions (n,), by coefficients (4,)."""
    return np.asarray(polynomial.polyval(position, powers))


def spring_slope_along(powers: Floats, position: Floats) -> Floats:
    """Return the derivative of that torque with respect to position, at positions (n,)."""
    return np.asarray(polynomial.polyval(position, polynomial.polyder(powers)))
