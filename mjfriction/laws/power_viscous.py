"""Coulomb friction with a viscous part that follows a power of the speed."""

from __future__ import annotations

from mjfriction.laws.curves import REST, holding, sign
from mjfriction.laws.declared import COULOMB
from mjfriction.laws.law import Floats, Law, kernel, positive
from mjfriction.parameter import Parameter


@kernel
def steady(v: float, ambient: Floats, p: Floats) -> float:
    """(F_c + F_p·|v|^n)·sgn v, with p = (F_c, F_p, n)."""
    return float((p[0] + p[1] * abs(v) ** p[2]) * sign(v))


@kernel
def advance(v: float, ambient: Floats, z: Floats, h: float, p: Floats, z_next: Floats) -> tuple[float, float]:
    """No state: the steady torque, made linear within the rest band, and its slope n·F_p·|v|^(n−1)."""
    towards, steepness = holding(v)
    speed = abs(v)
    level = p[0] + p[1] * speed ** p[2]
    return level * towards, level * steepness + p[2] * p[1] * max(speed, REST) ** (p[2] - 1.0)


POWER_VISCOUS = Law(
    name="power_viscous",
    summary="Coulomb plus a power of the speed; greases and harmonic drives with n around 0.5",
    captures="damping that flattens (n < 1) or steepens (n > 1) with speed without ever turning back",
    misses="a linear range near rest: for n < 1 the slope there is infinite",
    formula="(F_c + F_p·|v|^n)·sgn v",
    source="Ostwald-de Waele fluid; Harnoy, Friedland, Cohn, IEEE Control Systems 28(6), 2008",
    parameters=(
        COULOMB,
        positive("power_coefficient", "{force}·(s/{length})^n", "torque of the power term at unit speed", (0.1, 20.0)),
        Parameter("power", "1", "exponent n of the speed", lower=0.05, upper=4.0, typical=(0.4, 1.5)),
    ),
    steady=steady,
    advance=advance,
)
