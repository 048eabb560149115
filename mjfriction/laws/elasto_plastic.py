"""The elasto-plastic law: a bristle that is purely elastic until near its limit, so a stuck joint never drifts."""

from __future__ import annotations

import math

from mjfriction.laws.curves import sign, sliding_velocity, stribeck_level
from mjfriction.laws.declared import BRISTLE_DAMPING, BRISTLE_STIFFNESS, STATIC_ABOVE_COULOMB, STRIBECK_CURVE, VISCOUS
from mjfriction.laws.law import Floats, Law, kernel
from mjfriction.parameter import Parameter

ITERATIONS = 60


@kernel
def plastic_share(z: float, elastic: float, limit: float) -> tuple[float, float]:
    """Return α(z) for outward motion at z ≥ 0 and its slope: 0 up to ``elastic``, 1 from ``limit``, a sine between."""
    if z <= elastic:
        return 0.0, 0.0
    if z >= limit:
        return 1.0, 0.0
    angle = math.pi * (z - 0.5 * (limit + elastic)) / (limit - elastic)
    return 0.5 + 0.5 * math.sin(angle), 0.5 * math.pi / (limit - elastic) * math.cos(angle)


@kernel
def between(z: float, travel: float, elastic: float, limit: float) -> tuple[float, float]:
    """Return (z⁺, ∂z⁺/∂travel) with z⁺ = z + travel·(1 − α(z⁺)·z⁺/z_max), for z below ``limit`` (implicit Euler)."""
    low, high = z, min(z + travel, limit)
    guess = high
    for _ in range(ITERATIONS):
        share, rise = plastic_share(guess, elastic, limit)
        error = guess - z - travel * (1.0 - share * guess / limit)
        if error > 0.0:
            high = guess
        else:
            low = guess
        slope = 1.0 + travel * (share + rise * guess) / limit
        closer = guess - error / slope
        if not low < closer < high:
            closer = 0.5 * (low + high)
        if abs(closer - guess) <= 1e-14 * limit:
            break
        guess = closer
    share, rise = plastic_share(guess, elastic, limit)
    return guess, (1.0 - share * guess / limit) / (1.0 + travel * (share + rise * guess) / limit)


@kernel
def steady(v: float, ambient: Floats, p: Floats) -> float:
    """g(v)·sgn v + F_v·v, with p = (F_c, F_s, v_s, δ, σ₀, σ₁, F_v, z_ba share)."""
    return float(stribeck_level(v, p[0], p[1], p[2], p[3]) * sign(v) + p[6] * v)


@kernel
def advance(v: float, ambient: Floats, z: Floats, h: float, p: Floats, z_next: Floats) -> tuple[float, float]:
    """Step z = (z,) through its elastic travel, then the mixed range (implicit), or at the limit (closed solution)."""
    direction = 1.0 if v >= 0.0 else -1.0
    limit = stribeck_level(sliding_velocity(v, ambient), p[0], p[1], p[2], p[3]) / p[4]
    elastic = p[7] * p[0] / p[4]
    outward, travel = direction * z[0], abs(v) * h
    growth = 1.0  # ∂z⁺/∂travel
    moved = outward
    if moved < elastic:
        step = min(travel, elastic - moved)
        moved, travel = moved + step, travel - step
    if travel > 0.0 and moved >= elastic:
        if moved < limit:
            moved, growth = between(moved, travel, elastic, limit)
        elif limit > 0.0:
            decay = math.exp(-travel / limit)
            moved, growth = limit + (moved - limit) * decay, 0.0
        else:
            moved, growth = 0.0, 0.0
    z_next[0] = direction * moved
    torque = p[4] * z_next[0] + p[5] * (z_next[0] - z[0]) / h + p[6] * v
    return torque, (p[4] * h + p[5]) * growth + p[6]


ELASTO_PLASTIC = Law(
    name="elasto_plastic",
    summary="LuGre without its drift: the bristle is purely elastic until it nears its limit",
    captures="a stuck joint that stays where it is under vibration below breakaway, with LuGre's other effects",
    misses="inner hysteresis loops that close, plastic creep at very small travel",
    formula=(
        "dz/dt = v·(1 − α(z, v)·z/z_ss),   α = 0 for |z| ≤ z_ba or motion back, 1 for |z| ≥ z_ss, a sine between;   "
        "torque σ₀z + σ₁·dz/dt + F_v·v"
    ),
    source="Dupont, Hayward, Armstrong, Altpeter, IEEE Trans. Automatic Control 47(5), 2002",
    parameters=(
        *STRIBECK_CURVE,
        BRISTLE_STIFFNESS,
        BRISTLE_DAMPING,
        VISCOUS,
        Parameter(
            "elastic_share",
            "1",
            "share of the Coulomb deflection that is purely elastic",
            lower=0.0,
            upper=0.999,
            typical=(0.3, 0.9),
            default=0.7,
        ),
    ),
    steady=steady,
    advance=advance,
    states=1,
    exact_state=False,
    rules=(STATIC_ABOVE_COULOMB,),
)
