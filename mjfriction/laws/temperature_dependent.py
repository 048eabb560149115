"""Coulomb-viscous friction that changes with temperature."""

from __future__ import annotations

import math

from mjfriction.laws.ambient import ROOM_TEMPERATURE, TEMPERATURE
from mjfriction.laws.curves import holding, sign
from mjfriction.laws.declared import COULOMB, VISCOUS
from mjfriction.laws.law import Floats, Law, kernel
from mjfriction.parameter import Parameter

STEEPEST = 50.0  # the exponent is clipped here, so that it does not overflow at any temperature


@kernel
def levels(ambient: Floats, p: Floats) -> tuple[float, float]:
    """Return Coulomb level and damping at the temperature, with p = (F_c, F_v, α, β, T₀)."""
    warmer = ambient[TEMPERATURE] - p[4]
    return max(0.0, p[0] * (1.0 + p[2] * warmer)), p[1] * math.exp(min(STEEPEST, -p[3] * warmer))


@kernel
def steady(v: float, ambient: Floats, p: Floats) -> float:
    """F_c·(1 + α·ΔT)·sgn v + F_v·e^(−β·ΔT)·v, ΔT = T − T₀, with p = (F_c, F_v, α, β, T₀)."""
    coulomb, viscous = levels(ambient, p)
    return float(coulomb * sign(v) + viscous * v)


@kernel
def advance(v: float, ambient: Floats, z: Floats, h: float, p: Floats, z_next: Floats) -> tuple[float, float]:
    """No state: the steady torque, made linear within the rest band, and its slope."""
    towards, steepness = holding(v)
    coulomb, viscous = levels(ambient, p)
    return coulomb * towards + viscous * v, coulomb * steepness + viscous


TEMPERATURE_DEPENDENT = Law(
    name="temperature_dependent",
    summary="Coulomb-viscous that thins as the gear warms up",
    captures="the fall of viscous friction over the first half hour, and a Coulomb level that drifts with it",
    misses="temperature differences inside the joint: it reads one temperature",
    formula="F_c·(1 + α·(T − T₀))·sgn v + F_v·e^(−β·(T − T₀))·v",
    source="Bittencourt and Gunnarsson, ASME J. Dyn. Syst. Meas. Control 134(5), 2012; Reynolds' viscosity, 1886",
    parameters=(
        COULOMB,
        VISCOUS,
        Parameter(
            "coulomb_per_kelvin", "1/K", "relative change of the Coulomb level per kelvin", typical=(-0.01, 0.01)
        ),
        Parameter("viscous_decay", "1/K", "relative fall of the damping per kelvin", typical=(0.005, 0.05)),
        Parameter(
            "reference_temperature",
            "°C",
            "temperature at which the levels hold",
            lower=-273.15,
            typical=(15.0, 40.0),
            default=ROOM_TEMPERATURE,
        ),
    ),
    steady=steady,
    advance=advance,
    reads=(TEMPERATURE,),
)
