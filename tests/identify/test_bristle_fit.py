"""A bristle fitted to the friction simulated along a motion, statics from passes held; then all together."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mjfriction.identify.bristle_fit import BRISTLE, BristleFit, fit_bristle
from mjfriction.identify.friction_map import FrictionMap
from mjfriction.identify.map_fit import MapFit, fit_map
from mjfriction.laws.ambient import ambient
from mjfriction.laws.arctan import ARCTAN
from mjfriction.laws.law import Floats
from mjfriction.laws.lugre_arctan import LUGRE_ARCTAN

STEP, NOISE = 2e-3, 0.004  # s, N·m
# A soft contact on the curve of the manipulator paper's joint 3: it gives over a thousandth of the motion.
TRUE = {
    "static": 1.1257,
    "stribeck_fall": -0.5719,
    "viscous": 0.0057,
    "viscous_bend": -5.4e-6,
    "stribeck_steepness": 3.7748,
    "bristle_stiffness": 30.0,
    "bristle_damping": 1.0,
}


def passes() -> FrictionMap:
    speed = np.geomspace(0.02, 400.0, 20)
    statics = {name: value for name, value in TRUE.items() if name not in BRISTLE}
    friction = ARCTAN.along(speed, ambient(speed.size), ARCTAN.pack(statics))
    friction = friction + NOISE * np.random.default_rng(3).normal(size=speed.size)
    return FrictionMap(0, speed, friction, np.full(speed.size, NOISE), np.zeros(speed.size), np.ones(speed.size))


def course(bristle: bool = True) -> tuple[Floats, Floats]:
    time = np.arange(0.0, 12.0, STEP)
    speed = 8.0 * np.sin(2.0 * np.pi * 0.25 * time)
    around = ambient(time.size)
    if bristle:
        friction = LUGRE_ARCTAN.follow(speed, around, STEP, LUGRE_ARCTAN.pack(TRUE))[0]
    else:
        statics = {name: value for name, value in TRUE.items() if name not in BRISTLE}
        friction = ARCTAN.along(speed, around, ARCTAN.pack(statics))
    return speed, friction + NOISE * np.random.default_rng(4).normal(size=time.size)


def fitted(statics: MapFit, bristle: bool = True) -> BristleFit:
    return fit_bristle(LUGRE_ARCTAN, statics, passes(), "motor", 1.0, *course(bristle), STEP)


def test_stiffness_and_damping_are_found_with_the_statics_held() -> None:
    found = fitted(fit_map(passes(), ARCTAN, "motor", 1.0))
    for name in BRISTLE:
        assert found.values[name] == pytest.approx(TRUE[name], rel=0.05), name
    assert found.rms[1] < 0.3 * found.rms[0]
    assert found.rms[1] < 1.5 * NOISE


def test_all_together_puts_statics_right_that_were_off() -> None:
    off = fit_map(passes(), ARCTAN, "motor", 1.0)
    off = replace(off, values={**off.values, "static": 1.1 * off.values["static"]})
    found = fitted(off)
    assert found.rms[2] < 0.3 * found.rms[1]
    for name, truth in TRUE.items():
        assert found.together[name] == pytest.approx(truth, rel=0.05), name
        assert abs(found.together[name] - truth) < found.half[name], name


def test_a_motion_without_a_bristle_tells_none() -> None:
    found = fitted(fit_map(passes(), ARCTAN, "motor", 1.0), bristle=False)
    assert found.half["bristle_stiffness"] > found.together["bristle_stiffness"]
