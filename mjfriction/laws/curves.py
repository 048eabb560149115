"""Velocity curves shared by several laws, as compiled kernels."""

from __future__ import annotations

import math

from mjfriction.laws.ambient import SLIDING
from mjfriction.laws.law import Floats, kernel

FAR = 40.0  # e^(−40) is less than the rounding of 1
REST = 1e-10  # rad/s or m/s, half-width of the rest band, in which a law without state gives whatever holds the joint


@kernel
def sign(v: float) -> float:
    """Return −1, 0 or 1; the 0 at rest stands for Coulomb friction, which there is whatever holds the joint."""
    if v > 0.0:
        return 1.0
    if v < 0.0:
        return -1.0
    return 0.0


@kernel
def holding(v: float) -> tuple[float, float]:
    """Return the sign of ``v``, made linear within the rest band |v| < 1e-10, and its slope.

    Coulomb's law leaves the holding force at rest open.  A step that solves for the velocity at its end finds the one
    holding force within the band.
    """
    if v >= REST:
        return 1.0, 0.0
    if v <= -REST:
        return -1.0, 0.0
    return v / REST, 1.0 / REST


@kernel
def sliding_velocity(v: float, ambient: Floats) -> float:
    """Return the velocity at which a step evaluates a level that falls with speed: the ambient's if given, else ``v``.

    A simulation passes the velocity at the beginning of its step.  The torque then never falls as the velocity at the
    end of the step rises, so an implicit step has exactly one solution.  The level lags by one step, which is an error
    of first order, like the step's own.
    """
    given = ambient[SLIDING]
    return v if math.isnan(given) else float(given)


@kernel
def powered(base: float, exponent: float) -> float:
    """Return base^exponent for base ≥ 0; the common exponents 1 and 2 avoid the cost of a power."""
    if exponent == 2.0:
        return base * base
    if exponent == 1.0:
        return base
    return float(base**exponent)


@kernel
def stribeck_level(v: float, coulomb: float, static: float, stribeck_velocity: float, exponent: float) -> float:
    """Return the friction level F_c + (F_s − F_c)·exp(−|v/v_s|^δ), an even function of ``v``."""
    along = powered(abs(v) / stribeck_velocity, exponent)
    return coulomb + (static - coulomb) * math.exp(-along) if along < FAR else coulomb


@kernel
def lorentzian_level(v: float, coulomb: float, static: float, stribeck_velocity: float, exponent: float) -> float:
    """Return the friction level F_c + (F_s − F_c)/(1 + |v/v_s|^δ), an even function of ``v``."""
    return coulomb + (static - coulomb) / (1.0 + powered(abs(v) / stribeck_velocity, exponent))


@kernel
def arctan_level(v: float, static: float, fall: float, steepness: float) -> float:
    """Return the friction level τ_s + τ_sc·atan(δ|v|), an even function of ``v``, never below 0."""
    return max(0.0, static + fall * math.atan(steepness * abs(v)))
