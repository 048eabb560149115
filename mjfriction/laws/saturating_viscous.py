"""Coulomb friction with damping that saturates with speed."""

from __future__ import annotations

from mjfriction.laws.curves import holding, sign
from mjfriction.laws.declared import COULOMB, VISCOUS
from mjfriction.laws.law import Floats, Law, kernel
from mjfriction.parameter import Parameter


@kernel
def steady(v: float, ambient: Floats, p: Floats) -> float:
    """F_c·sgn v + F_v·v/(1 + |v|/v_h), with p = (F_c, F_v, v_h)."""
    return float(p[0] * sign(v) + p[1] * v / (1.0 + abs(v) / p[2]))


@kernel
def advance(v: float, ambient: Floats, z: Floats, h: float, p: Floats, z_next: Floats) -> tuple[float, float]:
    """No state: the steady torque, made linear within the rest band, and its slope F_v/(1 + |v|/v_h)²."""
    towards, steepness = holding(v)
    thinned = 1.0 + abs(v) / p[2]
    return p[0] * towards + p[1] * v / thinned, p[0] * steepness + p[1] / (thinned * thinned)


SATURATING_VISCOUS = Law(
    name="saturating_viscous",
    summary="Coulomb plus damping that levels off: shear-thinning grease",
    captures="damping linear near rest that approaches a ceiling F_v·v_h at speed",
    misses="damping that grows with speed",
    formula="F_c·sgn v + F_v·v/(1 + |v|/v_h)",
    source="Cross, J. Colloid Science 20(5), 1965, with exponent one",
    parameters=(
        COULOMB,
        VISCOUS,
        Parameter("half_velocity", "{length}/s", "speed at which damping has halved", lower=1e-9, typical=(0.1, 3.0)),
    ),
    steady=steady,
    advance=advance,
)
