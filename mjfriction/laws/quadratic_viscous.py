"""Coulomb-viscous friction whose viscous curve bends."""

from __future__ import annotations

from mjfriction.laws.curves import holding, sign
from mjfriction.laws.declared import COULOMB, VISCOUS
from mjfriction.laws.law import Floats, Law, kernel
from mjfriction.parameter import Parameter


@kernel
def steady(v: float, ambient: Floats, p: Floats) -> float:
    """F_c·sgn v + F_v·v + F_q·v·|v|, with p = (F_c, F_v, F_q)."""
    return float(p[0] * sign(v) + p[1] * v + p[2] * v * abs(v))


@kernel
def advance(v: float, ambient: Floats, z: Floats, h: float, p: Floats, z_next: Floats) -> tuple[float, float]:
    """No state: the steady torque, made linear within the rest band, and its slope with F_v + 2·F_q·|v| at least 0."""
    towards, steepness = holding(v)
    slope = max(0.0, p[1] + 2.0 * p[2] * abs(v))
    return p[0] * towards + p[1] * v + p[2] * v * abs(v), p[0] * steepness + slope


QUADRATIC_VISCOUS = Law(
    name="quadratic_viscous",
    summary="Coulomb-viscous whose damping grows (F_q > 0) or saturates (F_q < 0) with speed",
    captures="churning of lubricant (grows) or shear thinning (saturates) over the measured range",
    misses="what happens beyond the measured speeds: with F_q < 0 the curve comes down again",
    formula="F_c·sgn v + F_v·v + F_q·v·|v|",
    source="Armstrong-Hélouvry, Dupont, Canudas de Wit, Automatica 30(7), 1994, section 2.2",
    parameters=(
        COULOMB,
        VISCOUS,
        Parameter("quadratic", "{force}·s²/{length}²", "how the damping changes with speed", typical=(0.0, 5.0)),
    ),
    steady=steady,
    advance=advance,
)
