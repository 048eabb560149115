"""Coulomb-viscous friction whose level grows with what the transmission carries."""

from __future__ import annotations

from mjfriction.laws.curves import sign
from mjfriction.laws.law import Floats, Law, kernel, positive


@kernel
def steady(v: float, load: float, p: Floats) -> float:
    """(F_c + μ·|load|)·sgn v + F_v·v, with p = (F_c, μ, F_v)."""
    return float((p[0] + p[1] * abs(load)) * sign(v) + p[2] * v)


@kernel
def advance(v: float, load: float, z: Floats, h: float, p: Floats, z_next: Floats) -> tuple[float, float]:
    """No state: the steady torque, and F_v as its slope."""
    return (p[0] + p[1] * abs(load)) * sign(v) + p[2] * v, p[2]


LOAD_DEPENDENT = Law(
    name="load_dependent",
    summary="Coulomb-viscous with a level that grows with the transmitted torque; gears under gravity or payload",
    formula="(F_c + μ·|τ_load|)·sgn v + F_v·v",
    source="Dohring, Lee, Newman, IEEE ICRA 1993; Hamon, Gautier, Garrec, IEEE/RSJ IROS 2010",
    parameters=(
        positive("coulomb", "{force}", "level without load", (0.1, 20.0)),
        positive("load", "1", "growth of the level with the transmitted torque", (0.0, 0.3)),
        positive("viscous", "{force}·s/{length}", "damping", (0.0, 20.0)),
    ),
    steady=steady,
    advance=advance,
)
