"""Friction that falls from a breakaway level as the joint gathers speed."""

from __future__ import annotations

from mjfriction.laws.curves import sign, stribeck_level
from mjfriction.laws.law import Floats, Law, Ordering, kernel, positive
from mjfriction.parameter import Parameter


@kernel
def steady(v: float, load: float, p: Floats) -> float:
    """(F_c + (F_s − F_c)·exp(−|v/v_s|^δ))·sgn v + F_v·v, with p = (F_c, F_s, v_s, δ, F_v)."""
    return float(stribeck_level(v, p[0], p[1], p[2], p[3]) * sign(v) + p[4] * v)


@kernel
def advance(v: float, load: float, z: Floats, h: float, p: Floats, z_next: Floats) -> tuple[float, float]:
    """No state: the steady torque.  The falling branch has a negative slope; F_v is the part a step can rely on."""
    return stribeck_level(v, p[0], p[1], p[2], p[3]) * sign(v) + p[4] * v, p[4]


STRIBECK = Law(
    name="stribeck",
    summary="Coulomb-viscous with a higher level near rest that fades with speed; lubricated gears and bearings",
    formula="(F_c + (F_s − F_c)·exp(−|v/v_s|^δ))·sgn v + F_v·v",
    source="Bo and Pavelescu, Wear 82(3), 1982; Armstrong-Hélouvry et al., Automatica 30(7), 1994, eq. (5)",
    parameters=(
        positive("coulomb", "{force}", "level that remains at speed", (0.1, 20.0)),
        positive("static", "{force}", "level near rest, at least the Coulomb level", (0.1, 40.0)),
        Parameter(
            "stribeck_velocity",
            "{length}/s",
            "speed over which the extra level fades",
            lower=1e-9,
            typical=(1e-3, 0.3),
        ),
        Parameter(
            "stribeck_exponent", "1", "shape: 1 exponential, 2 Gaussian", lower=0.1, upper=10.0, typical=(0.5, 2.0)
        ),
        positive("viscous", "{force}·s/{length}", "damping", (0.0, 20.0)),
    ),
    steady=steady,
    advance=advance,
    orderings=(Ordering("static", "coulomb"),),
)
