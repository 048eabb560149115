"""The Leuven law: LuGre's bristle variable driving a Maxwell-slip hysteresis."""

from __future__ import annotations

import math

from mjfriction.laws.curves import sign, sliding_velocity, stribeck_level
from mjfriction.laws.declared import BRISTLE_DAMPING, STATIC_ABOVE_COULOMB, STRIBECK_CURVE, VISCOUS
from mjfriction.laws.law import Floats, Law, kernel
from mjfriction.laws.maxwell_slip import LEVEL, STIFFNESS
from mjfriction.laws.rules import BreakawayOrder, SumReaches
from mjfriction.parameter import Parameter

FIRST = 7  # where the elements' arrays start among the packed parameters
ITERATIONS = 100
FARTHEST = 1e6  # the ratio of hysteresis to level is clipped here, so that its power stays finite


@kernel
def hysteresis(z: Floats, shift: float, p: Floats) -> tuple[float, float]:
    """Return the Maxwell-slip torque after the elements (torques ``z``) are moved by ``shift``, and its stiffness."""
    count = z.shape[0]
    torque = stiffness = 0.0
    for i in range(count):
        force, level = z[i] + p[FIRST + i] * shift, p[FIRST + count + i]
        if -level < force < level:
            stiffness += p[FIRST + i]
        torque += min(level, max(-level, force))
    return torque, stiffness


@kernel
def yielding(ratio: float, shape: float) -> float:
    """Return sgn(r)·|r|^δ, the share of the motion that the hysteresis no longer follows."""
    return math.copysign(min(abs(ratio), FARTHEST) ** shape, ratio)


@kernel
def pulled(z: Floats, direction: float, travel: float, level: float, p: Floats) -> float:
    """Return u, the distance that dz/dt = v·(1 − sgn(r)|r|^δ) moves the elements along the motion (implicit Euler).

    r is the hysteresis torque along the motion divided by the level.  u − travel·(1 − sgn(r)|r|^δ) rises with u, and
    its root lies between 0 and the u given by the torque at the start; regula falsi (Illinois) finds it even where the
    power has an infinite slope.
    """
    first = travel * (1.0 - yielding(hysteresis(z, 0.0, p)[0] * direction / level, p[5]))
    if first == 0.0:
        return 0.0
    near, far = 0.0, first
    at_near = -first
    at_far = far - travel * (1.0 - yielding(hysteresis(z, far * direction, p)[0] * direction / level, p[5]))
    tolerance = 1e-12 * abs(first)
    for _ in range(ITERATIONS):
        if at_far == 0.0 or abs(far - near) <= tolerance:
            break
        guess = (near * at_far - far * at_near) / (at_far - at_near)
        error = guess - travel * (1.0 - yielding(hysteresis(z, guess * direction, p)[0] * direction / level, p[5]))
        if (error < 0.0) == (at_far < 0.0):
            at_near *= 0.5
        else:
            near, at_near = far, at_far
        far, at_far = guess, error
    return far


@kernel
def steady(v: float, ambient: Floats, p: Floats) -> float:
    """s(v)·sgn v + F_v·v, with p = (F_c, F_s, v_s, δ_s, σ₁, δ_l, F_v, k₁…k_N, W₁…W_N) and s the Stribeck level."""
    return float(stribeck_level(v, p[0], p[1], p[2], p[3]) * sign(v) + p[6] * v)


@kernel
def advance(v: float, ambient: Floats, z: Floats, h: float, p: Floats, z_next: Floats) -> tuple[float, float]:
    """Move the elements by the step of the bristle variable; z = (F₁…F_N), the elements' torques."""
    count = z.shape[0]
    direction = 1.0 if v >= 0.0 else -1.0
    level = max(1e-12, stribeck_level(sliding_velocity(v, ambient), p[0], p[1], p[2], p[3]))
    travel = abs(v) * h
    shift = pulled(z, direction, travel, level, p) if travel > 0.0 else 0.0
    torque, stiffness = hysteresis(z, shift * direction, p)
    for i in range(count):
        limit = p[FIRST + count + i]
        z_next[i] = min(limit, max(-limit, z[i] + p[FIRST + i] * shift * direction))
    ratio = torque * direction / level
    steep = p[5] * min(max(abs(ratio), 1e-6), FARTHEST) ** (p[5] - 1.0)
    growth = max(0.0, 1.0 - yielding(ratio, p[5])) / (1.0 + travel * steep * stiffness / level)
    damped = p[4] * shift * direction / h
    return torque + damped + p[6] * v, (stiffness * h + p[4]) * growth + p[6]


LEUVEN = Law(
    name="leuven",
    summary="hysteresis with memory before slip, the Stribeck curve at speed, one smooth law for both",
    captures="inner loops with memory of reversals, lag and the fall near rest",
    misses="the measured loop exactly: its elements see the bristle variable, not position, so fit them to that",
    formula=(
        "dz/dt = v·(1 − sgn(r)|r|^δ_l),   r = F_h(z)·sgn(v)/s(v),   torque F_h(z) + σ₁·dz/dt + F_v·v,   "
        "F_h of Maxwell-slip elements"
    ),
    source=(
        "Swevers, Al-Bender, Ganseman, Prajogo, IEEE Trans. Automatic Control 45(4), 2000; hysteresis by Maxwell-slip "
        "and r = F_h/s over the whole loop: Lampaert, Swevers, Al-Bender, same journal 47(4), 2002.  s(v) printed with "
        "its sign: r is positive where hysteresis and motion point the same way"
    ),
    parameters=(
        *STRIBECK_CURVE,
        BRISTLE_DAMPING,
        Parameter(
            "shape_exponent", "1", "δ_l: how early the hysteresis yields", lower=0.05, upper=20.0, typical=(0.5, 3.0)
        ),
        VISCOUS,
    ),
    elements=(STIFFNESS, LEVEL),
    steady=steady,
    advance=advance,
    states_per_element=1,
    exact_state=False,
    rules=(STATIC_ABOVE_COULOMB, BreakawayOrder("level", "stiffness"), SumReaches("level", "static")),
)
