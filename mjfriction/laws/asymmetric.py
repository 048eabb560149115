"""Coulomb-viscous friction with its own values in each direction."""

from __future__ import annotations

from mjfriction.laws.curves import holding
from mjfriction.laws.law import Floats, Law, kernel, positive


@kernel
def steady(v: float, ambient: Floats, p: Floats) -> float:
    """F_c⁺ + F_v⁺·v for v > 0 and −F_c⁻ + F_v⁻·v for v < 0, with p = (F_c⁺, F_c⁻, F_v⁺, F_v⁻)."""
    if v > 0.0:
        return float(p[0] + p[2] * v)
    if v < 0.0:
        return float(-p[1] + p[3] * v)
    return 0.0


@kernel
def advance(v: float, ambient: Floats, z: Floats, h: float, p: Floats, z_next: Floats) -> tuple[float, float]:
    """No state: the steady torque, made linear within the rest band, and the slope for the direction of motion."""
    towards, steepness = holding(v)
    level, damping = (p[0], p[2]) if v >= 0.0 else (p[1], p[3])
    return level * towards + damping * v, level * steepness + damping


ASYMMETRIC = Law(
    name="asymmetric",
    summary="Coulomb-viscous with its own level and damping in each direction; screws, seals, one-sided preload",
    captures="an axis that runs easier one way than the other",
    misses="the rise near rest; for any other law with two directions give the term a `negative` set",
    formula="F_c⁺ + F_v⁺·v  (v > 0),   −F_c⁻ + F_v⁻·v  (v < 0)",
    source="Janot, Gautier, Brunot, EMPS data set, Nonlinear System Identification Benchmarks, 2019",
    parameters=(
        positive("coulomb_positive", "{force}", "level while the joint moves in its positive direction", (0.1, 20.0)),
        positive("coulomb_negative", "{force}", "level while the joint moves in its negative direction", (0.1, 20.0)),
        positive("viscous_positive", "{force}·s/{length}", "damping in the positive direction", (0.0, 20.0)),
        positive("viscous_negative", "{force}·s/{length}", "damping in the negative direction", (0.0, 20.0)),
    ),
    steady=steady,
    advance=advance,
    odd=False,
)
