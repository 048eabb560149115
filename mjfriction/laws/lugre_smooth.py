"""The LuGre law of industrial manipulators with every discontinuity smoothed."""

from __future__ import annotations

import math

from mjfriction.laws.arctan import BEND, FALL, SHARPNESS, STATIC, STEEPNESS, TWO_OVER_PI, VISCOUS
from mjfriction.laws.curves import arctan_level, sliding_velocity
from mjfriction.laws.law import Floats, Law, kernel
from mjfriction.laws.lugre_arctan import DAMPING, STIFFNESS


@kernel
def steady(v: float, ambient: Floats, p: Floats) -> float:
    """S₀·g(v) + τ_v·v + τ_nlv·v²·S₀, S₀ = (2/π)·atan(K_v·v), with p = (τ_s, τ_sc, τ_v, τ_nlv, δ, σ₀, σ₁, K_v)."""
    smooth = TWO_OVER_PI * math.atan(p[7] * v)
    return float(smooth * arctan_level(v, p[0], p[1], p[4]) + p[2] * v + p[3] * v * v * smooth)


@kernel
def advance(v: float, ambient: Floats, z: Floats, h: float, p: Floats, z_next: Floats) -> tuple[float, float]:
    """Step z = (z,) by the closed solution of (26): z⁺ = z_ss + (z − z_ss)·e^(−k), z_ss = S₀g/σ₀, k = σ₀S₀vh/g."""
    smooth = TWO_OVER_PI * math.atan(p[7] * v)
    rising = TWO_OVER_PI * p[7] / (1.0 + (p[7] * v) ** 2)
    level = max(1e-12, arctan_level(sliding_velocity(v, ambient), p[0], p[1], p[4]))
    rate = p[5] * h / level
    end = smooth * level / p[5]
    grown = math.expm1(-rate * smooth * v)
    moved = (z[0] - end) * grown
    z_next[0] = z[0] + moved
    damping = (1.0 - TWO_OVER_PI * math.atan(p[4] * abs(v))) * p[6]
    growth = -grown * rising * level / p[5] + (end - z[0]) * (1.0 + grown) * rate * (rising * v + smooth)
    viscous = p[2] * v + p[3] * v * v * smooth
    torque = p[5] * z_next[0] + damping * moved / h + viscous
    return torque, (p[5] + damping / h) * max(0.0, growth) + max(0.0, p[2] + 2.0 * p[3] * v * smooth)


LUGRE_SMOOTH = Law(
    name="lugre_smooth",
    summary="the manipulators' dynamic law made smooth for solvers that need derivatives",
    captures="what lugre_arctan does at speeds above 1/K_v",
    misses="sticking below 1/K_v: there the bristle does not follow and a loaded joint creeps; prefer lugre_arctan",
    formula=(
        "dz/dt = S₁v − σ₀S₂z/g,   S₁ = S₀², S₂ = S₀v, S₀ = (2/π)·atan(K_v·v),   "
        "torque σ₀z + (1 − (2/π)·atan(δ|v|))·σ₁·dz/dt + τ_v·v + τ_nlv·v²·S₀"
    ),
    source="Indri et al., ETFA 2013, eqs. (22)-(29), with |v| in (24) and (29) and σ₁·dz/dt in (23)",
    parameters=(STATIC, FALL, VISCOUS, BEND, STEEPNESS, STIFFNESS, DAMPING, SHARPNESS),
    steady=steady,
    advance=advance,
    states=1,
)
