"""Friction that falls from a breakaway level with increasing speed."""

from __future__ import annotations

from mjfriction.laws.curves import holding, sign, sliding_velocity, stribeck_level
from mjfriction.laws.declared import STATIC_ABOVE_COULOMB, STRIBECK_CURVE, VISCOUS
from mjfriction.laws.law import Floats, Law, kernel


@kernel
def steady(v: float, ambient: Floats, p: Floats) -> float:
    """(F_c + (F_s − F_c)·exp(−|v/v_s|^δ))·sgn v + F_v·v, with p = (F_c, F_s, v_s, δ, F_v)."""
    return float(stribeck_level(v, p[0], p[1], p[2], p[3]) * sign(v) + p[4] * v)


@kernel
def advance(v: float, ambient: Floats, z: Floats, h: float, p: Floats, z_next: Floats) -> tuple[float, float]:
    """No state: the steady torque, and its slope without the negative part of the falling branch."""
    towards, steepness = holding(v)
    level = stribeck_level(sliding_velocity(v, ambient), p[0], p[1], p[2], p[3])
    return level * towards + p[4] * v, level * steepness + p[4]


STRIBECK = Law(
    name="stribeck",
    summary="Coulomb-viscous with a higher level near rest that fades with speed; lubricated gears and bearings",
    captures="the falling branch that makes slow motion stick and slip",
    misses="the elastic travel before slip, lag when speed changes, load and temperature",
    formula="(F_c + (F_s − F_c)·exp(−|v/v_s|^δ))·sgn v + F_v·v",
    source="Bo and Pavelescu, Wear 82(3), 1982; Armstrong-Hélouvry et al., Automatica 30(7), 1994, eq. (5)",
    parameters=(*STRIBECK_CURVE, VISCOUS),
    steady=steady,
    advance=advance,
    rules=(STATIC_ABOVE_COULOMB,),
)
