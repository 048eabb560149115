"""Breakaway friction that rises with the time a joint has been at rest."""

from __future__ import annotations

from mjfriction.laws.curves import sign, sliding_velocity
from mjfriction.laws.declared import (
    BRISTLE_STIFFNESS,
    COULOMB,
    STATIC,
    STATIC_ABOVE_COULOMB,
    STRIBECK_VELOCITY,
    VISCOUS,
)
from mjfriction.laws.law import Floats, Law, above_zero, kernel, positive
from mjfriction.laws.rules import Ordering


@kernel
def fallen(v: float, breakaway: float, coulomb: float, stribeck_velocity: float) -> float:
    """Return F_c + (F_b − F_c)/(1 + (v/v_s)²)."""
    return coulomb + (breakaway - coulomb) / (1.0 + (v / stribeck_velocity) ** 2)


@kernel
def steady(v: float, ambient: Floats, p: Floats) -> float:
    """Sliding without a preceding rest: the curve from F_s0, with p = (F_c, F_s0, F_s∞, γ, v_s, σ₀, F_v)."""
    return float(fallen(v, p[1], p[0], p[4]) * sign(v) + p[6] * v)


@kernel
def advance(v: float, ambient: Floats, z: Floats, h: float, p: Floats, z_next: Floats) -> tuple[float, float]:
    """Stretch or slip; z = (deflection, time stuck, increase of the breakaway level by the last rest)."""
    slid = sliding_velocity(v, ambient)
    trial = z[0] + v * h
    waited = z[1] + h
    added = max(z[2], (p[2] - p[1]) * waited / (waited + p[3]))
    if trial * v <= 0.0 or abs(p[5] * trial) <= fallen(slid, p[1] + added, p[0], p[4]):
        z_next[0], z_next[1], z_next[2] = trial, waited, added
        return p[5] * trial + p[6] * v, p[5] * h + p[6]
    # The increase gained at rest fades with travel, as the contact renews itself over the Stribeck length v_s·γ.
    kept = z[2] / (1.0 + abs(v) * h / (p[4] * p[3]))
    force = fallen(slid, p[1] + kept, p[0], p[4]) * sign(trial)
    z_next[0], z_next[1], z_next[2] = force / p[5], 0.0, kept
    return force + p[6] * v, p[6]


DWELL_TIME = Law(
    name="dwell_time",
    summary="a breakaway level that rises the longer the joint has stood still",
    captures="the first move after a rest that needs more torque than the next; stick-slip that dies out with speed",
    misses="lag in sliding (the published pure delay), inner hysteresis loops",
    formula=(
        "stuck: σ₀·x up to F_s(t) = F_s0 + (F_s∞ − F_s0)·t/(t + γ);   "
        "sliding: (F_c + (F_b − F_c)/(1 + (v/v_s)²))·sgn v;   + F_v·v"
    ),
    source=(
        "Armstrong-Hélouvry, Dupont, Canudas de Wit, Automatica 30(7), 1994, section 2.5 (seven-parameter model) "
        "without its frictional memory; what a rest added fades over the travel v_s·γ, which the paper leaves open"
    ),
    parameters=(
        COULOMB,
        STATIC,
        positive("static_rested", "{force}", "breakaway level after a very long rest", (0.2, 60.0)),
        above_zero("rise_time", "s", "rest after which half the rise is reached", (0.1, 10.0)),
        STRIBECK_VELOCITY,
        BRISTLE_STIFFNESS,
        VISCOUS,
    ),
    steady=steady,
    advance=advance,
    states=3,
    exact_state=False,
    rules=(STATIC_ABOVE_COULOMB, Ordering("static_rested", "static")),
)
