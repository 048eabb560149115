"""Maxwell-slip: springs in parallel, each with its own slider."""

from __future__ import annotations

from mjfriction.laws.curves import sign
from mjfriction.laws.declared import VISCOUS
from mjfriction.laws.law import Floats, Law, above_zero, kernel, positive
from mjfriction.laws.rules import BreakawayOrder


@kernel
def steady(v: float, ambient: Floats, p: Floats) -> float:
    """ΣWᵢ·sgn v + F_v·v, with p = (F_v, k₁…k_N, W₁…W_N)."""
    count = (p.shape[0] - 1) // 2
    level = 0.0
    for i in range(count):
        level += p[1 + count + i]
    return float(level * sign(v) + p[0] * v)


@kernel
def advance(v: float, ambient: Floats, z: Floats, h: float, p: Floats, z_next: Floats) -> tuple[float, float]:
    """Stretch every spring by v·h, limited by slip at its level; z = (F₁…F_N), the springs' torques."""
    count = z.shape[0]
    torque, slope = p[0] * v, p[0]
    for i in range(count):
        stiffness, level = p[1 + i], p[1 + count + i]
        force = z[i] + stiffness * v * h
        if force > level:
            force = level
        elif force < -level:
            force = -level
        else:
            slope += stiffness * h
        z_next[i] = force
        torque += force
    return torque, slope


STIFFNESS = above_zero("stiffness", "{force}/{length}", "stiffness of the element's spring", (1e2, 1e4))
LEVEL = positive("level", "{force}", "torque at which the element slips", (0.2, 5.0))

MAXWELL_SLIP = Law(
    name="maxwell_slip",
    summary="springs with sliders in parallel; hysteresis before slip with a memory of every reversal",
    captures="pre-sliding hysteresis of any shape: inner loops close and are wiped out as real contacts do",
    misses="everything that depends on speed: no fall near rest, no lag",
    formula="Fᵢ ← clip(Fᵢ + kᵢ·dx, ±Wᵢ),   torque ΣFᵢ + F_v·v",
    source="Iwan, ASME J. Applied Mechanics 33(4), 1966; Lampaert et al., 2004, eq. (7)",
    parameters=(VISCOUS,),
    elements=(STIFFNESS, LEVEL),
    steady=steady,
    advance=advance,
    states_per_element=1,
    rules=(BreakawayOrder("level", "stiffness"),),
)
