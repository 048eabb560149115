"""Coulomb-viscous friction beside a part that grows with speed, levels off, and differs between the directions."""

from __future__ import annotations

from mjfriction.laws.curves import holding, sign
from mjfriction.laws.declared import COULOMB, VISCOUS
from mjfriction.laws.law import Floats, Law, kernel
from mjfriction.parameter import Parameter


@kernel
def steady(v: float, ambient: Floats, p: Floats) -> float:
    """F_c·sgn v + F_v·v + F_a·|v|/(1 + |v|/v_h), with p = (F_c, F_v, F_a, v_h)."""
    speed = abs(v)
    return float(p[0] * sign(v) + p[1] * v + p[2] * speed / (1.0 + speed / p[3]))


@kernel
def advance(v: float, ambient: Floats, z: Floats, h: float, p: Floats, z_next: Floats) -> tuple[float, float]:
    """No state: the steady torque, made linear within the rest band, and its slope with F_v ± F_a/(1 + |v|/v_h)² at
    least 0.
    """
    towards, steepness = holding(v)
    speed = abs(v)
    levelled = 1.0 + speed / p[3]
    slope = p[1] + sign(v) * p[2] / (levelled * levelled)
    return p[0] * towards + p[1] * v + p[2] * speed / levelled, p[0] * steepness + max(0.0, slope)


ASYMMETRIC_CURVE = Law(
    name="asymmetric_curve",
    summary="Coulomb-viscous beside a difference of the directions that grows with speed and levels off",
    captures="a screw or seal whose directions differ by a curve over speed, not by a level or a damping",
    misses="a difference at rest, which is an offset or the law `asymmetric`; beside less damping it drives one way",
    formula="F_c·sgn v + F_v·v + F_a·|v|/(1 + |v|/v_h)",
    source="the even part of saturating_viscous; Cross, J. Colloid Science 20(5), 1965, with exponent one",
    parameters=(
        COULOMB,
        VISCOUS,
        Parameter(
            "asymmetry",
            "{force}·s/{length}",
            "half the difference of the directions, per speed near rest: more forward where it is above 0",
            typical=(0.0, 5.0),
        ),
        Parameter(
            "half_velocity",
            "{length}/s",
            "speed at which the difference is half of what it would be without levelling off",
            lower=1e-9,
            typical=(0.1, 3.0),
        ),
    ),
    steady=steady,
    advance=advance,
    odd=False,
)
