"""Load-dependent friction of a gear that loses more when it drives than when it is driven, or the other way round."""

from __future__ import annotations

from mjfriction.laws.ambient import LOAD
from mjfriction.laws.curves import holding, sign
from mjfriction.laws.declared import VISCOUS
from mjfriction.laws.law import Floats, Law, kernel, positive


@kernel
def steady(v: float, ambient: Floats, p: Floats) -> float:
    """(F_c + μ·|τ|)·sgn v + F_v·v, μ = μ_d where τ·v > 0 and μ_b elsewhere, with p = (F_c, μ_d, μ_b, F_v)."""
    slip = p[1] if ambient[LOAD] * v > 0.0 else p[2]
    return float((p[0] + slip * abs(ambient[LOAD])) * sign(v) + p[3] * v)


@kernel
def advance(v: float, ambient: Floats, z: Floats, h: float, p: Floats, z_next: Floats) -> tuple[float, float]:
    """No state: the steady torque, made linear within the rest band, and its slope."""
    towards, steepness = holding(v)
    slip = p[1] if ambient[LOAD] * v > 0.0 else p[2]
    level = p[0] + slip * abs(ambient[LOAD])
    return level * towards + p[3] * v, level * steepness + p[3]


GEARED_LOAD = Law(
    name="geared_load",
    summary="load-dependent friction, driving and braking apart; worm, spindle and multi-stage gears",
    captures="lifting that costs more friction than lowering, up to self-locking",
    misses="the rise near rest, the elastic travel before slip",
    formula="(F_c + μ·|τ_load|)·sgn v + F_v·v,   μ = μ_driving (τ·v > 0) or μ_braking",
    source="Hamon, Gautier, Garrec, IEEE/RSJ IROS 2010; Abba and Sardain, IEEE/RSJ IROS 2003",
    parameters=(
        positive("coulomb", "{force}", "level without load", (0.1, 20.0)),
        positive("load_driving", "1", "growth of the level with the torque, the drive pushing the load", (0.0, 0.3)),
        positive("load_braking", "1", "growth of the level with the torque, the load pushing the drive", (0.0, 0.3)),
        VISCOUS,
    ),
    steady=steady,
    advance=advance,
    reads=(LOAD,),
)
