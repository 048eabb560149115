"""Friction that falls from a breakaway level along a Lorentzian curve."""

from __future__ import annotations

from mjfriction.laws.curves import holding, lorentzian_level, sign, sliding_velocity
from mjfriction.laws.declared import STATIC_ABOVE_COULOMB, STRIBECK_CURVE, VISCOUS
from mjfriction.laws.law import Floats, Law, kernel


@kernel
def steady(v: float, ambient: Floats, p: Floats) -> float:
    """(F_c + (F_s − F_c)/(1 + |v/v_s|^δ))·sgn v + F_v·v, with p = (F_c, F_s, v_s, δ, F_v)."""
    return float(lorentzian_level(v, p[0], p[1], p[2], p[3]) * sign(v) + p[4] * v)


@kernel
def advance(v: float, ambient: Floats, z: Floats, h: float, p: Floats, z_next: Floats) -> tuple[float, float]:
    """No state: the steady torque, and its slope without the negative part of the falling branch."""
    towards, steepness = holding(v)
    level = lorentzian_level(sliding_velocity(v, ambient), p[0], p[1], p[2], p[3])
    return level * towards + p[4] * v, level * steepness + p[4]


LORENTZIAN = Law(
    name="lorentzian",
    summary="the Stribeck curve with a long tail; grease that takes a wide range of speed to build its film",
    captures="a falling branch whose tail reaches far beyond the Stribeck velocity",
    misses="the elastic travel before slip, lag when speed changes, load and temperature",
    formula="(F_c + (F_s − F_c)/(1 + |v/v_s|^δ))·sgn v + F_v·v",
    source="Hess and Soom, ASME J. Tribology 112(1), 1990; Armstrong-Hélouvry et al., Automatica 30(7), 1994, eq. (6)",
    parameters=(*STRIBECK_CURVE, VISCOUS),
    steady=steady,
    advance=advance,
    rules=(STATIC_ABOVE_COULOMB,),
)
