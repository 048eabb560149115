"""The static friction law of industrial manipulators, in arctangents."""

from __future__ import annotations

import math

from mjfriction.laws.law import Floats, Law, above_zero, kernel, positive
from mjfriction.parameter import Parameter

TWO_OVER_PI = 2.0 / math.pi


@kernel
def arctan_torque(
    v: float, static: float, fall: float, viscous: float, bend: float, steepness: float, sharpness: float
) -> tuple[float, float]:
    """Return law (14) at ``v`` and its slope, or 0 where the slope is negative."""
    turn = TWO_OVER_PI * math.atan(sharpness * v)
    turning = TWO_OVER_PI * sharpness / (1.0 + (sharpness * v) ** 2)
    torque = static * turn + fall * math.atan(steepness * v) + viscous * v + bend * v * v * turn
    slope = (
        static * turning
        + fall * steepness / (1.0 + (steepness * v) ** 2)
        + viscous
        + bend * (2.0 * v * turn + v * v * turning)
    )
    return torque, max(0.0, slope)


@kernel
def steady(v: float, ambient: Floats, p: Floats) -> float:
    """Law (14), with p = (τ_s, τ_sc, τ_v, τ_nlv, δ, K_v)."""
    return float(arctan_torque(v, p[0], p[1], p[2], p[3], p[4], p[5])[0])


@kernel
def advance(v: float, ambient: Floats, z: Floats, h: float, p: Floats, z_next: Floats) -> tuple[float, float]:
    """No state: the steady torque and its slope."""
    return arctan_torque(v, p[0], p[1], p[2], p[3], p[4], p[5])


STATIC = positive("static", "{force}", "level at breakaway τ_s", (0.5, 2.0))
FALL = Parameter(
    "stribeck_fall",
    "{force}",
    "τ_sc: −2/π of what the level loses with speed; negative",
    upper=0.0,
    typical=(-0.3, -0.05),
)
VISCOUS = positive("viscous", "{force}·s/{length}", "damping τ_v", (0.001, 0.02))
BEND = Parameter("viscous_bend", "{force}·s²/{length}²", "bend of the damping τ_nlv", typical=(-1e-5, 1e-5))
STEEPNESS = above_zero("stribeck_steepness", "s/{length}", "how fast the level falls, δ", (1.0, 12.0))
SHARPNESS = above_zero(
    "sign_sharpness", "s/{length}", "K_v: how closely the arctangent follows the sign", (1e6, 1e9), default=1e9
)

ARCTAN = Law(
    name="arctan",
    summary="the smooth four-term law of geared industrial arms: breakaway, fall, damping and its bend",
    captures="the whole static curve of a robot joint from crawling to full speed, without a discontinuity",
    misses="load and temperature, the elastic travel before slip; at rest it creeps where K_v is low",
    formula="(2/π)·τ_s·atan(K_v·v) + τ_sc·atan(δ·v) + τ_v·v + τ_nlv·v²·(2/π)·atan(K_v·v)",
    source="Indri, Lazzero, Antoniazza, Bottero, ETFA 2013, eq. (14); the Coulomb level at speed is τ_s + (π/2)·τ_sc",
    parameters=(STATIC, FALL, VISCOUS, BEND, STEEPNESS, SHARPNESS),
    steady=steady,
    advance=advance,
)
