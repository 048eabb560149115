"""Friction of a hydraulic cylinder, which grows with the pressures its seals hold."""

from __future__ import annotations

import math

from mjfriction.laws.ambient import PRESSURE_HEAD, PRESSURE_ROD
from mjfriction.laws.curves import holding
from mjfriction.laws.law import Floats, Law, kernel, positive
from mjfriction.parameter import Parameter

STEEPEST = 50.0  # the exponent is clipped here, so that it does not overflow at any speed


@kernel
def one_way(v: float, ambient: Floats, p: Floats, at: int) -> tuple[float, float, float]:
    """Return level at rest, speed-dependent part, and its slope, for the direction whose x₁…x₅ start at ``at``.

    Level and speed-dependent part are positive where they act against the motion; x₃(p₁ − p₂) and x₄p₂ belong to the
    level.
    """
    forward = 1.0 if at == 0 else -1.0
    difference = forward * (ambient[PRESSURE_HEAD] - ambient[PRESSURE_ROD])
    pressed = max(0.0, p[at] + p[at + 2] * difference + p[at + 3] * ambient[PRESSURE_ROD])
    growth = math.exp(min(STEEPEST, p[at + 1] * abs(v)))
    return pressed, p[at] * (growth - 1.0) + p[at + 4] * abs(v), max(0.0, p[at] * p[at + 1] * growth + p[at + 4])


@kernel
def steady(v: float, ambient: Floats, p: Floats) -> float:
    """Law (2) of the direction of motion, with p = (x₁…x₅ extending, x₁…x₅ retracting)."""
    if v == 0.0:
        return 0.0
    pressed, moving, _ = one_way(v, ambient, p, 0 if v > 0.0 else 5)
    return (pressed + moving) if v > 0.0 else -(pressed + moving)


@kernel
def advance(v: float, ambient: Floats, z: Floats, h: float, p: Floats, z_next: Floats) -> tuple[float, float]:
    """No state: the steady force, its level at rest made linear within the rest band, and its slope."""
    towards, steepness = holding(v)
    pressed, moving, slope = one_way(v, ambient, p, 0 if v >= 0.0 else 5)
    return pressed * towards + (moving if v >= 0.0 else -moving), pressed * steepness + slope


def _direction(name: str) -> tuple[Parameter, ...]:
    return (
        positive(f"level_{name}", "{force}", f"x₁, level without pressure, {name}", (10.0, 500.0)),
        Parameter(
            f"growth_{name}",
            "s/{length}",
            f"x₂, growth of that level with speed, {name}",
            typical=(0.0, 0.05),
            default=0.0,
        ),
        Parameter(
            f"pressure_difference_{name}",
            "{force}/Pa",
            f"x₃, growth with p₁ − p₂ (counted along the motion), {name}",
            typical=(0.0, 1e-4),
            default=0.0,
        ),
        Parameter(
            f"rod_pressure_{name}",
            "{force}/Pa",
            f"x₄, growth with the rod side's pressure, {name}",
            typical=(0.0, 1e-4),
            default=0.0,
        ),
        positive(f"viscous_{name}", "{force}·s/{length}", f"x₅, damping, {name}", (0.0, 500.0), default=0.0),
    )


PRESSURE = Law(
    name="pressure",
    summary="hydraulic cylinder: seals pressed on by the chambers, extension and retraction apart",
    captures="friction that follows the chamber pressures, and wipers that drag only when the rod comes in",
    misses="the elastic travel before slip, stick-slip at very low speed",
    formula="(x₁·e^(x₂|v|) + x₃·(p₁ − p₂)·sgn v + x₄·p₂ + x₅·|v|)·sgn v, its own x for each direction",
    source=(
        "Bonchis, Ha, Corke, Rye, Model-based friction compensation in hydraulic servo systems, eq. (2), unreadable in "
        "print; the form that fits its Table 1, read with |v|.  "
        "Its models: 1 drops x₄, 2 is whole, 3 drops x₂, 4 drops x₂, x₃ and x₄: what is dropped is 0"
    ),
    parameters=(*_direction("extending"), *_direction("retracting")),
    steady=steady,
    advance=advance,
    reads=(PRESSURE_HEAD, PRESSURE_ROD),
    odd=False,
)
