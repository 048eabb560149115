"""Coulomb friction alone."""

from __future__ import annotations

from mjfriction.laws.curves import holding, sign
from mjfriction.laws.declared import COULOMB as LEVEL
from mjfriction.laws.law import Floats, Law, kernel


@kernel
def steady(v: float, ambient: Floats, p: Floats) -> float:
    """F_c·sgn v, with p = (F_c,)."""
    return float(p[0] * sign(v))


@kernel
def advance(v: float, ambient: Floats, z: Floats, h: float, p: Floats, z_next: Floats) -> tuple[float, float]:
    """No state: the steady torque, made linear within the rest band, and its slope."""
    towards, steepness = holding(v)
    return p[0] * towards, p[0] * steepness


COULOMB = Law(
    name="coulomb",
    summary="a constant level against the motion",
    captures="the deadband of force below which nothing moves",
    misses="everything that changes with speed, and the elastic travel before slip",
    formula="F_c·sgn v",
    source="Coulomb, Théorie des machines simples, 1785; Armstrong-Hélouvry et al., Automatica 30(7), 1994, section 2",
    parameters=(LEVEL,),
    steady=steady,
    advance=advance,
)
