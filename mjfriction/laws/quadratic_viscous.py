"""Coulomb-viscous friction whose viscous curve bends."""

from __future__ import annotations

from mjfriction.laws.curves import sign
from mjfriction.laws.law import Floats, Law, kernel, positive
from mjfriction.parameter import Parameter


@kernel
def steady(v: float, load: float, p: Floats) -> float:
    """F_c·sgn v + F_v·v + F_q·v·|v|, with p = (F_c, F_v, F_q)."""
    return float(p[0] * sign(v) + p[1] * v + p[2] * v * abs(v))


@kernel
def advance(v: float, load: float, z: Floats, h: float, p: Floats, z_next: Floats) -> tuple[float, float]:
    """No state: the steady torque.  Its slope F_v + 2·F_q·|v| counts only where it is positive."""
    return p[0] * sign(v) + p[1] * v + p[2] * v * abs(v), max(0.0, p[1] + 2.0 * p[2] * abs(v))


QUADRATIC_VISCOUS = Law(
    name="quadratic_viscous",
    summary="Coulomb-viscous whose damping grows (F_q > 0) or saturates (F_q < 0) with speed",
    formula="F_c·sgn v + F_v·v + F_q·v·|v|",
    source="Armstrong-Hélouvry, Dupont, Canudas de Wit, Automatica 30(7), 1994, section 2.2",
    parameters=(
        positive("coulomb", "{force}", "friction level that does not depend on speed", (0.1, 20.0)),
        positive("viscous", "{force}·s/{length}", "damping near rest", (0.0, 20.0)),
        Parameter("quadratic", "{force}·s²/{length}²", "how the damping changes with speed", typical=(0.0, 5.0)),
    ),
    steady=steady,
    advance=advance,
)
