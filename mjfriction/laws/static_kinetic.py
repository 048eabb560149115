"""Friction with a steep slope below a threshold velocity and a gentle one above."""

from __future__ import annotations

from mjfriction.laws.curves import holding, sign
from mjfriction.laws.law import Floats, Law, kernel, positive
from mjfriction.parameter import Parameter


@kernel
def steady(v: float, ambient: Floats, p: Floats) -> float:
    """(F_0 + b₁·min(|v|, v_t) + b₂·max(|v| − v_t, 0))·sgn v, with p = (F_0, b₁, b₂, v_t)."""
    speed = abs(v)
    return float((p[0] + p[1] * min(speed, p[3]) + p[2] * max(speed - p[3], 0.0)) * sign(v))


@kernel
def advance(v: float, ambient: Floats, z: Floats, h: float, p: Floats, z_next: Floats) -> tuple[float, float]:
    """No state: the steady torque, its level at rest made linear within the rest band, and its slope."""
    towards, steepness = holding(v)
    speed = abs(v)
    sloped = (p[1] * min(speed, p[3]) + p[2] * max(speed - p[3], 0.0)) * sign(v)
    return p[0] * towards + sloped, p[0] * steepness + (p[1] if speed < p[3] else p[2])


STATIC_KINETIC = Law(
    name="static_kinetic",
    summary="two slopes, steep below a threshold velocity and gentle above; hydraulic cylinders",
    captures="seal friction that builds up over the first millimetres per second and then hardly grows",
    misses="dependence on pressure, a falling branch, the elastic travel before slip",
    formula="(F_0 + b₁·min(|v|, v_t) + b₂·max(|v| − v_t, 0))·sgn v",
    source="Bonchis, Ha, Corke, Rye, Model-based friction compensation in hydraulic servo systems, Figure 2",
    parameters=(
        positive("level", "{force}", "level at rest, 0 where friction starts from nothing", (0.0, 20.0)),
        positive("slope_below", "{force}·s/{length}", "slope below the threshold", (10.0, 200.0)),
        positive("slope_above", "{force}·s/{length}", "slope above the threshold", (0.0, 10.0)),
        Parameter("threshold_velocity", "{length}/s", "where the slope changes", lower=0.0, typical=(1e-3, 0.1)),
    ),
    steady=steady,
    advance=advance,
)
