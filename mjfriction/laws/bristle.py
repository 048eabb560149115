"""The step of one bristle whose deflection saturates at a velocity-dependent level (LuGre and its relatives)."""

from __future__ import annotations

import math

from mjfriction.laws.curves import FAR
from mjfriction.laws.law import kernel

UNSEEN = 1e-17  # for exponents below this, the exponential differs from 1 by less than rounding


@kernel
def faded(v: float, damping_velocity: float) -> float:
    """Return e^(−(v/v_d)²), the share of the bristle damping that is left at ``v``."""
    exponent = (v / damping_velocity) ** 2
    return math.exp(-exponent) if exponent > UNSEEN else 1.0


@kernel
def bristle_step(
    v: float, z: float, h: float, level: float, stiffness: float, damping: float
) -> tuple[float, float, float]:
    """Return (z⁺, torque, slope) after ``h`` seconds at velocity ``v``.

    For constant v, dz/dt = v − σ₀|v|z/g has the solution z⁺ = z_ss + (z − z_ss)·e^(−k) with z_ss = g·sgn(v)/σ₀ and
    k = σ₀|v|h/g.  The torque is σ₀z⁺ + σ₁·(z⁺ − z)/h: the spring at the end of the step, which keeps stiff bristles
    from oscillating, and the mean of σ₁·dz/dt over the step.  The slope is computed with g held constant.
    """
    if v == 0.0 or level <= 0.0:
        kept = z if level > 0.0 else 0.0
        return kept, stiffness * kept, stiffness * h + damping
    direction = 1.0 if v > 0.0 else -1.0
    rate = stiffness * h / level
    end = direction * level / stiffness
    # expm1 keeps the small changes in deflection at slow motion that e^(−k) − 1 would round away.
    reach = rate * abs(v)
    gone = math.expm1(-reach) if reach < FAR else -1.0
    moved = (z - end) * gone
    z_next = z + moved
    growth = (1.0 + gone) * max(0.0, h - direction * rate * z)
    per_step = damping / h
    return z_next, stiffness * z_next + per_step * moved, (stiffness + per_step) * growth
