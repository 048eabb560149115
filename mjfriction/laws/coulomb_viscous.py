"""Coulomb friction with viscous damping."""

from __future__ import annotations

from mjfriction.laws.curves import holding, sign
from mjfriction.laws.declared import COULOMB, VISCOUS
from mjfriction.laws.law import Floats, Law, kernel


@kernel
def steady(v: float, ambient: Floats, p: Floats) -> float:
    """F_c·sgn v + F_v·v, with p = (F_c, F_v)."""
    return float(p[0] * sign(v) + p[1] * v)


@kernel
def advance(v: float, ambient: Floats, z: Floats, h: float, p: Floats, z_next: Floats) -> tuple[float, float]:
    """No state: the steady torque, made linear within the rest band, and its slope."""
    towards, steepness = holding(v)
    return p[0] * towards + p[1] * v, p[0] * steepness + p[1]


COULOMB_VISCOUS = Law(
    name="coulomb_viscous",
    summary="a constant level against the motion, plus damping; the first model to try",
    captures="the bulk of friction of a geared joint at moderate speed",
    misses="the rise near rest, bends at speed, the elastic travel before slip",
    formula="F_c·sgn v + F_v·v",
    source="Armstrong-Hélouvry, Dupont, Canudas de Wit, Automatica 30(7), 1994, section 2",
    parameters=(COULOMB, VISCOUS),
    steady=steady,
    advance=advance,
)
