"""Coulomb friction with viscous damping."""

from __future__ import annotations

from mjfriction.laws.curves import sign
from mjfriction.laws.law import Floats, Law, kernel, positive


@kernel
def steady(v: float, load: float, p: Floats) -> float:
    """F_c·sgn v + F_v·v, with p = (F_c, F_v)."""
    return float(p[0] * sign(v) + p[1] * v)


@kernel
def advance(v: float, load: float, z: Floats, h: float, p: Floats, z_next: Floats) -> tuple[float, float]:
    """No state: the steady torque, and F_v as its slope."""
    return p[0] * sign(v) + p[1] * v, p[1]


COULOMB_VISCOUS = Law(
    name="coulomb_viscous",
    summary="a constant level against the motion, plus damping; the first model to try",
    formula="F_c·sgn v + F_v·v",
    source="Armstrong-Hélouvry, Dupont, Canudas de Wit, Automatica 30(7), 1994, section 2",
    parameters=(
        positive("coulomb", "{force}", "friction level that does not depend on speed", (0.1, 20.0)),
        positive("viscous", "{force}·s/{length}", "damping", (0.0, 20.0)),
    ),
    steady=steady,
    advance=advance,
)
