"""Coulomb-viscous friction of a cylinder whose seals are pressed by either chamber and by the pressure difference."""

from __future__ import annotations

from mjfriction.laws.ambient import PRESSURE_HEAD, PRESSURE_ROD
from mjfriction.laws.curves import holding, sign
from mjfriction.laws.declared import COULOMB, VISCOUS
from mjfriction.laws.law import Floats, Law, kernel
from mjfriction.parameter import Parameter


@kernel
def level(ambient: Floats, p: Floats) -> float:
    """Return the level under the chambers' pressures, never below 0, with p = (F_c, F_v, h, r, d)."""
    head, rod = ambient[PRESSURE_HEAD], ambient[PRESSURE_ROD]
    return float(max(0.0, p[0] + p[2] * head + p[3] * rod + p[4] * abs(head - rod)))


@kernel
def steady(v: float, ambient: Floats, p: Floats) -> float:
    """(F_c + h·p₁ + r·p₂ + d·|p₁ − p₂|)·sgn v + F_v·v, with p = (F_c, F_v, h, r, d)."""
    return float(level(ambient, p) * sign(v) + p[1] * v)


@kernel
def advance(v: float, ambient: Floats, z: Floats, h: float, p: Floats, z_next: Floats) -> tuple[float, float]:
    """No state: the steady force, its level made linear within the rest band, and its slope."""
    towards, steepness = holding(v)
    pressed = level(ambient, p)
    return pressed * towards + p[1] * v, pressed * steepness + p[1]


def _per_pascal(name: str, meaning: str) -> Parameter:
    return Parameter(name, "{force}/Pa", f"growth of the level with {meaning}", typical=(0.0, 1e-5))


PRESSED_SEALS = Law(
    name="pressed_seals",
    summary="Coulomb-viscous whose level grows with the pressures in a cylinder's chambers",
    captures="rod and piston seals that press harder the more they hold, alike in both directions",
    misses="directions that differ, and a level that grows with speed, which `pressure` has",
    formula="(F_c + h·p₁ + r·p₂ + d·|p₁ − p₂|)·sgn v + F_v·v",
    source=(
        "A seal presses with the pressure that it holds: the rod's with p₂, the piston's with |p₁ − p₂|; h = r is the "
        "form in which pressures add up.  With d = 0 it is law (2) of Bonchis, Ha, Corke, Rye, x₃ = ±h, x₄ = h + r"
    ),
    parameters=(
        COULOMB,
        VISCOUS,
        _per_pascal("head", "the pressure on the head's side"),
        _per_pascal("rod", "the pressure on the rod's side"),
        _per_pascal("difference", "the difference of the two, whichever is higher"),
    ),
    steady=steady,
    advance=advance,
    reads=(PRESSURE_HEAD, PRESSURE_ROD),
)
