"""Dahl's solid friction: a spring that yields as it nears the Coulomb level."""

from __future__ import annotations

import math

from mjfriction.laws.curves import sign
from mjfriction.laws.declared import BRISTLE_STIFFNESS, COULOMB, VISCOUS
from mjfriction.laws.law import Floats, Law, kernel
from mjfriction.parameter import Parameter


@kernel
def remaining(start: float, travel: float, exponent: float) -> float:
    """Return u after ``travel`` ≥ 0, where du/ds = −|u|^δ·sgn u and u(0) = ``start``.

    u = 1 − F·sgn(v)/F_c is the remaining share of the level; s is the travel divided by F_c/σ₀.
    """
    size = abs(start)
    if size == 0.0:
        return 0.0
    if abs(exponent - 1.0) < 1e-9:
        left = size * math.exp(-travel)
    else:
        inner = size ** (1.0 - exponent) + (exponent - 1.0) * travel
        # With an exponent below 1, the level is reached after a finite travel.
        left = inner ** (1.0 / (1.0 - exponent)) if inner > 0.0 else 0.0
    return left if start > 0.0 else -left


@kernel
def steady(v: float, ambient: Floats, p: Floats) -> float:
    """F_c·sgn v + F_v·v, with p = (F_c, σ₀, δ, F_v)."""
    return float(p[0] * sign(v) + p[3] * v)


@kernel
def advance(v: float, ambient: Floats, z: Floats, h: float, p: Floats, z_next: Floats) -> tuple[float, float]:
    """Step F by its closed solution; z = (F,), the friction without its viscous part."""
    force = z[0]
    if v == 0.0 or p[0] <= 0.0:
        z_next[0] = force if p[0] > 0.0 else 0.0
        return z_next[0] + p[3] * v, (p[1] * h if p[0] > 0.0 else 0.0) + p[3]
    direction = 1.0 if v > 0.0 else -1.0
    left = remaining(1.0 - force * direction / p[0], p[1] * h * abs(v) / p[0], p[2])
    z_next[0] = direction * p[0] * (1.0 - left)
    stiffness = p[1] * left ** p[2] if left > 0.0 else 0.0
    return z_next[0] + p[3] * v, stiffness * h + p[3]


DAHL = Law(
    name="dahl",
    summary="a spring that yields into Coulomb friction; rolling bearings at small travel",
    captures="the elastic travel before slip and its hysteresis, alike at every speed",
    misses="the rise near rest, inner loops that close (no memory of reversals), creep under vibration is too strong",
    formula="dF/dx = σ₀·|1 − (F/F_c)·sgn v|^δ·sgn(1 − (F/F_c)·sgn v),   torque F + F_v·v",
    source="Dahl, Aerospace Corporation TOR-158(3107-18), 1968; Lampaert et al., 2004, eq. (1)",
    parameters=(
        COULOMB,
        BRISTLE_STIFFNESS,
        Parameter(
            "shape_exponent",
            "1",
            "δ: how the spring yields, 1 exponentially",
            lower=0.1,
            upper=20.0,
            typical=(0.6, 3.0),
        ),
        VISCOUS,
    ),
    steady=steady,
    advance=advance,
    states=1,
)
