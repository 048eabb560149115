"""The LuGre law over a Lorentzian Stribeck curve."""

from __future__ import annotations

from mjfriction.laws.bristle import bristle_step, faded
from mjfriction.laws.curves import lorentzian_level, sign, sliding_velocity
from mjfriction.laws.law import Floats, Law, kernel
from mjfriction.laws.lugre import LUGRE


@kernel
def steady(v: float, ambient: Floats, p: Floats) -> float:
    """g(v)·sgn v + F_v·v, with p = (F_c, F_s, v_s, δ, σ₀, σ₁, F_v, v_d) and g the Lorentzian level."""
    return float(lorentzian_level(v, p[0], p[1], p[2], p[3]) * sign(v) + p[6] * v)


@kernel
def advance(v: float, ambient: Floats, z: Floats, h: float, p: Floats, z_next: Floats) -> tuple[float, float]:
    """Step the bristle deflection z = (z,) by its closed solution at velocity ``v``."""
    level = lorentzian_level(sliding_velocity(v, ambient), p[0], p[1], p[2], p[3])
    z_next[0], torque, slope = bristle_step(v, z[0], h, level, p[4], p[5] * faded(v, p[7]))
    return torque + p[6] * v, slope + p[6]


LUGRE_LORENTZIAN = Law(
    name="lugre_lorentzian",
    summary="LuGre whose Stribeck curve has a long tail",
    captures=LUGRE.captures,
    misses=LUGRE.misses,
    formula="LuGre with g = F_c + (F_s − F_c)/(1 + |v/v_s|^δ)",
    source=f"Hess and Soom, ASME J. Tribology 112(1), 1990, in the law of {LUGRE.source}",
    parameters=LUGRE.parameters,
    steady=steady,
    advance=advance,
    states=1,
    rules=LUGRE.rules,
)
