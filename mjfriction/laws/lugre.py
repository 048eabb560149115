"""The LuGre law: bristles whose deflection saturates along the Stribeck curve."""

from __future__ import annotations

from mjfriction.laws.bristle import bristle_step, faded
from mjfriction.laws.curves import sign, sliding_velocity, stribeck_level
from mjfriction.laws.declared import BRISTLE_DAMPING, BRISTLE_STIFFNESS, STATIC_ABOVE_COULOMB, STRIBECK_CURVE, VISCOUS
from mjfriction.laws.law import Floats, Law, above_zero, kernel

# With a damping velocity that no joint reaches, the damping does not fade: the law of 1995.
NEVER = 1e12


@kernel
def steady(v: float, ambient: Floats, p: Floats) -> float:
    """g(v)·sgn v + F_v·v, with p = (F_c, F_s, v_s, δ, σ₀, σ₁, F_v, v_d) and g the Stribeck level."""
    return float(stribeck_level(v, p[0], p[1], p[2], p[3]) * sign(v) + p[6] * v)


@kernel
def advance(v: float, ambient: Floats, z: Floats, h: float, p: Floats, z_next: Floats) -> tuple[float, float]:
    """Step the bristle deflection z = (z,) by its closed solution at velocity ``v``."""
    level = stribeck_level(sliding_velocity(v, ambient), p[0], p[1], p[2], p[3])
    z_next[0], torque, slope = bristle_step(v, z[0], h, level, p[4], p[5] * faded(v, p[7]))
    return torque + p[6] * v, slope + p[6]


DAMPING_VELOCITY = above_zero(
    "damping_velocity", "{length}/s", "speed over which the bristle damping fades", (0.1, 10.0), default=NEVER
)

LUGRE = Law(
    name="lugre",
    summary="bristles over the Stribeck curve; the usual dynamic law",
    captures="elastic travel before slip, stick-slip, lag when speed changes, breakaway that depends on rate",
    misses="inner hysteresis loops that close (no memory of reversals), so it drifts under small vibration",
    formula=(
        "dz/dt = v − σ₀|v|z/g(v),   torque σ₀z + σ₁·e^(−(v/v_d)²)·dz/dt + F_v·v,   "
        "g = F_c + (F_s − F_c)·exp(−|v/v_s|^δ)"
    ),
    source=(
        "Canudas de Wit, Olsson, Åström, Lischinsky, IEEE Trans. Automatic Control 40(3), 1995; fading damping: "
        "Olsson, PhD thesis, Lund, 1996"
    ),
    parameters=(
        *STRIBECK_CURVE,
        BRISTLE_STIFFNESS,
        BRISTLE_DAMPING,
        VISCOUS,
        DAMPING_VELOCITY,
    ),
    steady=steady,
    advance=advance,
    states=1,
    rules=(STATIC_ABOVE_COULOMB,),
)
