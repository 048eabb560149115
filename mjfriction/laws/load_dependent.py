"""Coulomb-viscous friction whose level grows with the torque that the transmission carries."""

from __future__ import annotations

from mjfriction.laws.ambient import LOAD
from mjfriction.laws.curves import holding, sign
from mjfriction.laws.declared import VISCOUS
from mjfriction.laws.law import Floats, Law, kernel, positive


@kernel
def steady(v: float, ambient: Floats, p: Floats) -> float:
    """(F_c + μ·|τ|)·sgn v + F_v·v, with p = (F_c, μ, F_v) and τ the load."""
    return float((p[0] + p[1] * abs(ambient[LOAD])) * sign(v) + p[2] * v)


@kernel
def advance(v: float, ambient: Floats, z: Floats, h: float, p: Floats, z_next: Floats) -> tuple[float, float]:
    """No state: the steady torque, made linear within the rest band, and its slope."""
    towards, steepness = holding(v)
    level = p[0] + p[1] * abs(ambient[LOAD])
    return level * towards + p[2] * v, level * steepness + p[2]


LOAD_DEPENDENT = Law(
    name="load_dependent",
    summary="Coulomb-viscous with a level that grows with the transmitted torque; gears under gravity or payload",
    captures="joints that drag more under gravity, payload or acceleration",
    misses="a difference between driving and being driven (geared_load has it), the rise near rest",
    formula="(F_c + μ·|τ_load|)·sgn v + F_v·v",
    source="Dohring, Lee, Newman, IEEE ICRA 1993; Hamon, Gautier, Garrec, IEEE/RSJ IROS 2010",
    parameters=(
        positive("coulomb", "{force}", "level without load", (0.1, 20.0)),
        positive("load", "1", "growth of the level with the transmitted torque", (0.0, 0.3)),
        VISCOUS,
    ),
    steady=steady,
    advance=advance,
    reads=(LOAD,),
)
