"""The Generalized Maxwell-Slip law: elements that stick as springs and slip towards the Stribeck curve."""

from __future__ import annotations

import math

from mjfriction.laws.curves import REST, sign, sliding_velocity, stribeck_level
from mjfriction.laws.declared import STATIC_ABOVE_COULOMB, STRIBECK_CURVE, VISCOUS
from mjfriction.laws.law import Floats, Law, above_zero, kernel, positive
from mjfriction.laws.maxwell_slip import STIFFNESS
from mjfriction.laws.rules import BreakawayOrder, SumIsOne

FIRST = 6  # where the elements' arrays start among the packed parameters


@kernel
def steady(v: float, ambient: Floats, p: Floats) -> float:
    """s(v)·sgn v + F_v·v, with p = (F_c, F_s, v_s, δ, C, F_v, k₁…k_N, α₁…α_N), Σα = 1, s the Stribeck level."""
    return float(stribeck_level(v, p[0], p[1], p[2], p[3]) * sign(v) + p[5] * v)


@kernel
def advance(v: float, ambient: Floats, z: Floats, h: float, p: Floats, z_next: Floats) -> tuple[float, float]:
    """Step every element by its closed solution; z = (F₁…F_N, m₁…m_N): torques, and modes 0 stuck, ±1 slipping.

    Within one step an element may stick first and slip for the rest of the step.  Within the rest band |v| < 1e-10,
    the rate of slipping falls linearly to 0, so that the torque does not jump as the joint comes to rest.
    """
    count = z.shape[0] // 2
    direction = sign(v)
    level = stribeck_level(sliding_velocity(v, ambient), p[0], p[1], p[2], p[3])
    fade = -p[4] / level if level > 0.0 else -math.inf
    awake = min(1.0, abs(v) / REST)
    whole = math.exp(fade * h * awake) if awake > 0.0 else 1.0
    torque, slope = p[5] * v, p[5]
    for i in range(count):
        stiffness, limit = p[FIRST + i], p[FIRST + count + i] * level
        force, mode = z[i], z[count + i]
        slipping = mode * direction > 0.0
        decay = whole
        if not slipping:
            mode = 0.0
            room = limit - force * direction
            reach = stiffness * abs(v) * h
            if reach <= room or direction == 0.0:
                force += stiffness * v * h
                slope += stiffness * h
            else:
                if room > 0.0:
                    force = limit * direction
                decay = math.exp(fade * h * awake * (1.0 - max(0.0, room) / reach))
                mode, slipping = direction, True
        if slipping:
            force = limit * direction + (force - limit * direction) * decay
        z_next[i], z_next[count + i] = force, mode
        torque += force
    return torque, slope


GMS = Law(
    name="gms",
    summary="elements that stick as springs and slip towards the Stribeck curve; the most complete of the family",
    captures="hysteresis with memory before slip, the Stribeck curve, lag in sliding, breakaway that depends on rate",
    misses="a smooth passage from stick to slip (each element switches), load and temperature",
    formula=(
        "stuck: dFᵢ/dt = kᵢ·v until |Fᵢ| > αᵢ·s(v);   slipping: dFᵢ/dt = C·(αᵢ·sgn v − Fᵢ/s(v)) until v passes zero;   "
        "torque ΣFᵢ + F_v·v"
    ),
    source=(
        "Lampaert, Al-Bender, Swevers, Int. Conf. Physics and Control, 2003; Al-Bender, Lampaert, Swevers, IEEE Trans. "
        "Automatic Control 50(11), 2005.  s(v) is printed with its sign"
    ),
    parameters=(
        *STRIBECK_CURVE,
        positive(
            "attraction", "{force}/s", "C: how fast slipping elements approach the Stribeck curve", (200.0, 2000.0)
        ),
        VISCOUS,
    ),
    elements=(STIFFNESS, above_zero("share", "1", "αᵢ: the element's share of the level", (0.1, 0.4))),
    steady=steady,
    advance=advance,
    states_per_element=2,
    rules=(STATIC_ABOVE_COULOMB, BreakawayOrder("share", "stiffness"), SumIsOne("share")),
)
