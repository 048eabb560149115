"""The arctangent law of industrial manipulators with levels that follow the transmitted torque."""

from __future__ import annotations

from mjfriction.laws.ambient import LOAD
from mjfriction.laws.arctan import BEND, FALL, SHARPNESS, STATIC, STEEPNESS, VISCOUS, arctan_torque
from mjfriction.laws.law import Floats, Law, kernel
from mjfriction.parameter import Parameter


@kernel
def loaded(v: float, ambient: Floats, p: Floats) -> tuple[float, float]:
    """Return torque and slope, with p = (τ_s0, τ_sc0, τ_v, τ_nlv, δ, K_v, τ_s,m, τ_sc,m)."""
    load = abs(ambient[LOAD])
    static = max(0.0, p[0] + p[6] * load)
    fall = min(0.0, p[1] + p[7] * load)
    return arctan_torque(v, static, fall, p[2], p[3], p[4], p[5])


@kernel
def steady(v: float, ambient: Floats, p: Floats) -> float:
    """Law (14) with levels (31) and (32) at the given load."""
    return float(loaded(v, ambient, p)[0])


@kernel
def advance(v: float, ambient: Floats, z: Floats, h: float, p: Floats, z_next: Floats) -> tuple[float, float]:
    """No state: the steady torque and its slope."""
    return loaded(v, ambient, p)


ARCTAN_LOAD = Law(
    name="arctan_load",
    summary="the arctangent law with breakaway level and fall linear in the transmitted torque",
    captures="what payload and gravity add to the static curve of a robot joint",
    misses="a difference between driving and being driven, the elastic travel before slip",
    formula="law arctan with τ_s = τ_s0 + τ_s,m·|τ_load| and τ_sc = τ_sc0 + τ_sc,m·|τ_load|",
    source=(
        "Indri et al., ETFA 2013, eqs. (30)-(32); (30) prints −τ_sc where (14) has +, the sign of (14) is taken, and "
        "|τ_m| so that a load from either side presses alike"
    ),
    parameters=(
        STATIC,
        FALL,
        VISCOUS,
        BEND,
        STEEPNESS,
        SHARPNESS,
        Parameter("static_load", "1", "growth of the breakaway level with the torque", typical=(0.0, 0.1)),
        Parameter("fall_load", "1", "change of the fall with the torque", typical=(-0.05, 0.0)),
    ),
    steady=steady,
    advance=advance,
    reads=(LOAD,),
)
