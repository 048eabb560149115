"""The LuGre law over the arctangent curve of industrial manipulators."""

from __future__ import annotations

import math

from mjfriction.laws.arctan import BEND, FALL, STATIC, STEEPNESS, VISCOUS
from mjfriction.laws.bristle import bristle_step
from mjfriction.laws.curves import arctan_level, sign, sliding_velocity
from mjfriction.laws.law import Floats, Law, above_zero, kernel, positive

TWO_OVER_PI = 2.0 / math.pi

STIFFNESS = above_zero("bristle_stiffness", "{force}/{length}", "stiffness of the contact at rest", (8e3, 8e5))
DAMPING = positive("bristle_damping", "{force}·s/{length}", "damping of the contact's deflection", (200.0, 1500.0))


@kernel
def steady(v: float, ambient: Floats, p: Floats) -> float:
    """g(v)·sgn v + τ_v·v + τ_nlv·v·|v|, with p = (τ_s, τ_sc, τ_v, τ_nlv, δ, σ₀, σ₁)."""
    return float(arctan_level(v, p[0], p[1], p[4]) * sign(v) + p[2] * v + p[3] * v * abs(v))


@kernel
def advance(v: float, ambient: Floats, z: Floats, h: float, p: Floats, z_next: Floats) -> tuple[float, float]:
    """Step the bristle deflection z = (z,) by its closed solution at velocity ``v``."""
    level = arctan_level(sliding_velocity(v, ambient), p[0], p[1], p[4])
    fading = 1.0 - TWO_OVER_PI * math.atan(p[4] * abs(v))
    z_next[0], torque, slope = bristle_step(v, z[0], h, level, p[5], fading * p[6])
    return torque + p[2] * v + p[3] * v * abs(v), slope + max(0.0, p[2] + 2.0 * p[3] * abs(v))


LUGRE_ARCTAN = Law(
    name="lugre_arctan",
    summary="the dynamic law of industrial manipulators: bristles over the arctangent curve",
    captures="a robot joint's whole static curve with its elastic travel before slip",
    misses="inner hysteresis loops that close; with measured σ₁ it damps so strongly that slip starts late",
    formula=(
        "dz/dt = v − σ₀|v|z/g,   torque σ₀z + (1 − (2/π)·atan(δ|v|))·σ₁·dz/dt + τ_v·v + τ_nlv·v·|v|,   "
        "g = τ_s + τ_sc·atan(δ|v|)"
    ),
    source=(
        "Indri et al., ETFA 2013, eqs. (22)-(25) and (29); (23) prints σ₁z for σ₁·dz/dt, and (24) and (29) need |v| "
        "or the law is not odd"
    ),
    parameters=(STATIC, FALL, VISCOUS, BEND, STEEPNESS, STIFFNESS, DAMPING),
    steady=steady,
    advance=advance,
    states=1,
)
