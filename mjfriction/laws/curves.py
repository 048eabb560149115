"""Velocity curves that several laws share, as compiled kernels."""

from __future__ import annotations

import math

from mjfriction.laws.law import kernel


@kernel
def sign(v: float) -> float:
    """Return −1, 0 or 1; at rest Coulomb friction is whatever holds the joint, and 0 stands for it."""
    if v > 0.0:
        return 1.0
    if v < 0.0:
        return -1.0
    return 0.0


@kernel
def stribeck_level(v: float, coulomb: float, static: float, stribeck_velocity: float, exponent: float) -> float:
    """Return the friction level F_c + (F_s − F_c)·exp(−|v/v_s|^δ), an even function of ``v``."""
    return coulomb + (static - coulomb) * math.exp(-((abs(v) / stribeck_velocity) ** exponent))
