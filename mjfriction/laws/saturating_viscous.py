"""Coulomb friction with damping that saturates with speed."""

from __future__ import annotations

from mjfriction.laws.curves import holding, powered, sign
from mjfriction.laws.declared import COULOMB, VISCOUS
from mjfriction.laws.law import Floats, Law, kernel
from mjfriction.parameter import Parameter


@kernel
def thinned(speed: float, p: Floats) -> float:
    """By what factor damping has fallen: (1 + (|v|/v_h)^n)^(1/n), with p = (F_c, F_v, v_h, n)."""
    return float(powered(1.0 + powered(speed / p[2], p[3]), 1.0 / p[3]))


@kernel
def steady(v: float, ambient: Floats, p: Floats) -> float:
    """F_c·sgn v + F_v·v/(1 + (|v|/v_h)^n)^(1/n), with p = (F_c, F_v, v_h, n)."""
    return float(p[0] * sign(v) + p[1] * v / thinned(abs(v), p))


@kernel
def advance(v: float, ambient: Floats, z: Floats, h: float, p: Floats, z_next: Floats) -> tuple[float, float]:
    """No state: the steady torque, made linear within the rest band, and its slope F_v/(1 + (|v|/v_h)^n)^(1 + 1/n)."""
    towards, steepness = holding(v)
    factor = thinned(abs(v), p)
    return p[0] * towards + p[1] * v / factor, p[0] * steepness + p[1] / powered(factor, 1.0 + p[3])


SATURATING_VISCOUS = Law(
    name="saturating_viscous",
    summary="Coulomb plus damping that levels off: shear-thinning grease",
    captures="damping linear near rest that approaches a ceiling F_v·v_h at speed",
    misses="damping that grows with speed",
    formula="F_c·sgn v + F_v·v/(1 + (|v|/v_h)^n)^(1/n)",
    source="Cross, J. Colloid Science 20(5), 1965, exponent one; for others Yasuda et al., Rheologica Acta 20, 1981",
    parameters=(
        COULOMB,
        VISCOUS,
        Parameter(
            "half_velocity",
            "{length}/s",
            "speed at which unchanged damping would reach the ceiling; for n = 1 it has halved there",
            lower=1e-9,
            typical=(0.1, 3.0),
        ),
        Parameter(
            "saturation_exponent",
            "1",
            "exponent n: how abruptly damping levels off; 1 gently, 3 as tanh does",
            lower=0.1,
            upper=20.0,
            typical=(0.5, 4.0),
            default=1.0,
        ),
    ),
    steady=steady,
    advance=advance,
)
