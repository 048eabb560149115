"""Friction whose level varies along the stroke."""

from __future__ import annotations

import math

from mjfriction.laws.ambient import POSITION
from mjfriction.laws.curves import holding, sign
from mjfriction.laws.declared import COULOMB, VISCOUS
from mjfriction.laws.law import Floats, Law, above_zero, kernel
from mjfriction.parameter import Parameter


@kernel
def level_at(position: float, p: Floats) -> float:
    """Return max(0, F_c + Σ aᵢ·cos(kᵢq) + bᵢ·sin(kᵢq)), with p = (F_c, F_v, k₁…k_N, a₁…a_N, b₁…b_N)."""
    count = (p.shape[0] - 2) // 3
    level = p[0]
    for i in range(count):
        angle = p[2 + i] * position
        level += p[2 + count + i] * math.cos(angle) + p[2 + 2 * count + i] * math.sin(angle)
    return float(max(0.0, level))


@kernel
def steady(v: float, ambient: Floats, p: Floats) -> float:
    """The level at the position, against the motion, + F_v·v."""
    return float(level_at(ambient[POSITION], p) * sign(v) + p[1] * v)


@kernel
def advance(v: float, ambient: Floats, z: Floats, h: float, p: Floats, z_next: Floats) -> tuple[float, float]:
    """No state: the steady torque, made linear within the rest band, and its slope."""
    towards, steepness = holding(v)
    level = level_at(ambient[POSITION], p)
    return level * towards + p[1] * v, level * steepness + p[1]


POSITION_DEPENDENT = Law(
    name="position_dependent",
    summary="Coulomb-viscous whose level varies along the stroke as a Fourier series",
    captures="eccentric gears, a bent screw, a worn stretch: friction that turns with the direction of motion",
    misses="torques that do not turn with direction (cogging, springs): those are not friction",
    formula="max(0, F_c + Σ aᵢ·cos(kᵢq) + bᵢ·sin(kᵢq))·sgn v + F_v·v",
    source="Armstrong, IEEE ICRA 1988; Huo et al., Mechatronics 2011 (Fourier form)",
    parameters=(COULOMB, VISCOUS),
    elements=(
        above_zero("wavenumber", "1/{length}", "angular wavenumber of the wave", (1.0, 60.0)),
        Parameter("cosine", "{force}", "share that follows cos(kq)", typical=(-0.05, 0.05)),
        Parameter("sine", "{force}", "share that follows sin(kq)", typical=(-0.05, 0.05)),
    ),
    steady=steady,
    advance=advance,
    reads=(POSITION,),
)
