"""Starting values for the fit of a law, from the level, the damping and the speeds that the joint itself shows."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass

from mjfriction.laws.law import Law

DYNAMIC = frozenset({"bristle_stiffness", "bristle_damping", "attraction"})
"""Parameters that only the motion around reversals shows; they are fitted after all others."""

LEFT_AS_DECLARED = frozenset(
    {
        "sign_sharpness",
        "damping_velocity",
        "elastic_share",
        "reference_temperature",
        "saturation_exponent",
        # At steady speeds, these and the rod pressure together reproduce the measured force of a cylinder, whatever its
        # friction is.
        *(f"{name}_{way}" for name in ("growth", "pressure_difference") for way in ("extending", "retracting")),
    }
)
"""Parameters with a default that no ordinary log can improve on."""

FADING_SPEEDS = (0.05, 0.15, 0.4)  # speeds over which a level may fade, as shares of the joint's usual speed
GIVING_TRAVELS = (1e-4, 1e-3, 1e-2)  # travels over which a bristle may yield, as shares of the stroke
EXCESS = 0.3  # share of the level by which friction near rest may exceed it
TWO_OVER_PI = 2.0 / math.pi


@dataclass(frozen=True)
class Usual:
    """Rough values of a joint, on the side of the law.

    They are its friction ``level`` and ``damping``, its usual ``speed`` (RMS), its ``stroke``, and its usual ``load``
    (RMS).
    """

    level: float
    damping: float
    speed: float
    stroke: float
    load: float


def starts(law: Law, usual: Usual, fading: Sequence[float] = FADING_SPEEDS) -> list[dict[str, float]]:
    """Return sets of values for a law's single parameters to start a fit from.

    ``fading`` are the fading speeds to try, as shares of the usual speed.
    """
    names = [parameter.name for parameter in law.parameters]
    speeds = fading if {"stribeck_velocity", "stribeck_steepness", "half_velocity"} & set(names) else fading[:1]
    travels = GIVING_TRAVELS if "bristle_stiffness" in names else (1e-3,)
    out = []
    for share, travel in itertools.product(speeds, travels):
        own = _values(usual, share * usual.speed, travel * usual.stroke)
        defaults = {p.name: p.default for p in law.parameters if p.default is not None and p.name in LEFT_AS_DECLARED}
        out.append({name: own[name] for name in names if name not in defaults} | defaults)
    return out


def _values(usual: Usual, fading: float, travel: float) -> dict[str, float]:
    level, damping = usual.level, usual.damping
    stiffness = level / travel
    return {
        "coulomb": level,
        "static": (1.0 + EXCESS) * level,
        "static_rested": (1.0 + 2.0 * EXCESS) * level,
        "rise_time": 1.0,
        "stribeck_velocity": fading,
        "stribeck_exponent": 1.0,
        "viscous": damping,
        "coulomb_positive": level,
        "coulomb_negative": level,
        "viscous_positive": damping,
        "viscous_negative": damping,
        "quadratic": 0.0,
        "asymmetry": 0.0,
        "power_coefficient": max(damping, 0.1 * level / usual.speed) * usual.speed**0.3,
        "power": 0.7,
        "half_velocity": 5.0 * fading,
        "load": 0.1 * level / max(usual.load, 1e-9),
        "load_driving": 0.1 * level / max(usual.load, 1e-9),
        "load_braking": 0.1 * level / max(usual.load, 1e-9),
        "stribeck_fall": -EXCESS * TWO_OVER_PI * level,
        "viscous_bend": 0.0,
        "stribeck_steepness": 1.0 / fading,
        "static_load": 0.1 * level / max(usual.load, 1e-9),
        "fall_load": -0.01 * level / max(usual.load, 1e-9),
        "bristle_stiffness": stiffness,
        "bristle_damping": 0.1 * level / usual.speed,
        "shape_exponent": 1.0,
        "level": level,
        "slope_below": level / fading,
        "slope_above": damping,
        "threshold_velocity": fading,
        **{f"level_{way}": level for way in ("extending", "retracting")},
        **{f"viscous_{way}": damping for way in ("extending", "retracting")},
        **{f"rod_pressure_{way}": 0.0 for way in ("extending", "retracting")},
        **dict.fromkeys(("head", "rod", "difference"), 0.0),
        "attraction": 50.0 * level,
        "coulomb_per_kelvin": 0.0,
        "viscous_decay": 0.01,
    }
