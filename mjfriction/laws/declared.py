"""Parameters that many laws share, declared once."""

from __future__ import annotations

from mjfriction.laws.law import above_zero, positive
from mjfriction.laws.rules import Ordering
from mjfriction.parameter import Parameter

COULOMB = positive("coulomb", "{force}", "friction level that does not depend on speed", (0.1, 20.0))
STATIC = positive("static", "{force}", "level near rest, at least the Coulomb level", (0.1, 40.0))
VISCOUS = positive("viscous", "{force}·s/{length}", "damping", (0.0, 20.0))
STRIBECK_VELOCITY = Parameter(
    "stribeck_velocity", "{length}/s", "speed over which the extra level fades", lower=1e-9, typical=(1e-3, 0.3)
)
STRIBECK_EXPONENT = Parameter(
    "stribeck_exponent",
    "1",
    "shape of the fall: 1 exponential, 2 Gaussian",
    lower=0.1,
    upper=10.0,
    typical=(0.5, 2.0),
)
BRISTLE_STIFFNESS = above_zero("bristle_stiffness", "{force}/{length}", "stiffness of the contact at rest", (1e3, 1e5))
BRISTLE_DAMPING = positive("bristle_damping", "{force}·s/{length}", "damping of the contact's deflection", (0.0, 20.0))
STATIC_ABOVE_COULOMB = Ordering("static", "coulomb")
STRIBECK_CURVE = (COULOMB, STATIC, STRIBECK_VELOCITY, STRIBECK_EXPONENT)
