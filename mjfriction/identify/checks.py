"""What a fit does not say by its numbers: parameters at a bound, not determined by the log, or not distinguishable."""

from __future__ import annotations

import itertools
import math

import numpy as np

from mjfriction.identify.falling import FASTER
from mjfriction.identify.fit import LawFit
from mjfriction.laws.rules import scalar
from mjfriction.record.log import Floats

ALIKE = 0.98  # correlation of two parameters above which only a combination of them is known
LOOSE = 1.0  # a shape whose half-width exceeds this share of its value is not determined
UNSEEN = 1e-9  # share of the friction's RMS below which a parameter's own effect is invisible
AT_BOUND = 1e-6  # distance from a bound, relative to its size, within which a coordinate is at the bound
BACKWARD = 0.02  # motion is one way only where less than this share of the samples in motion goes the other way
FALLEN = 0.8  # share of a fading level that must be gone at the fastest speed for what lies beyond to show
BEYOND = frozenset({"coulomb", "viscous"})
SHAPES = frozenset(
    {"bristle_stiffness", "bristle_damping", "stribeck_velocity", "stribeck_steepness", "stribeck_exponent"}
)


def notes(fit: LawFit, half: Floats, covariance: Floats, *, falls: bool) -> dict[str, str]:
    """Return a remark for every parameter that needs one, by name.

    ``half`` (told,) are the 95 % half-widths, ``covariance`` (told, told) is that of the values; ``falls`` says whether
    friction still falls at the fastest speed.  Elements get no remark: a log says little about one of them by itself,
    but much about all together.
    """
    low, high = fit.coordinates.bounds()
    names, values = fit.coordinates.single, fit.told
    out = dict.fromkeys(names, FASTER) if falls else {}
    seen = np.sqrt(np.mean(np.square(fit.slopes), axis=0)) * np.maximum(np.abs(fit.x), 1e-3)
    for k, name in enumerate(names):
        if seen[k] < UNSEEN * float(np.sqrt(np.mean(np.square(fit.problem.target)))):
            out[name] = "this log does not show it"
        elif half[k] > LOOSE * abs(values[name]) and name in SHAPES:
            out[name] = "not fixed by this log: slower motion with more reversals would show it"
        for bound, which in ((low[k], "lowest"), (high[k], "highest")):
            if np.isfinite(bound) and abs(fit.x[k] - bound) < AT_BOUND * (1.0 + abs(bound)):
                out[name] = f"at the {which} value allowed"
    for name, said in _of_motion(fit).items():
        out.setdefault(name, said)
    deviation = np.sqrt(np.maximum(np.diag(covariance), 1e-300))
    correlation = covariance / np.outer(deviation, deviation)
    for a, b in itertools.combinations(range(len(names)), 2):
        if abs(correlation[a, b]) > ALIKE:
            for one, other in ((a, b), (b, a)):
                out.setdefault(names[one], f"not told from {names[other]} on this motion")
    return out


def _of_motion(fit: LawFit) -> dict[str, str]:
    # What the motion itself cannot determine.
    out: dict[str, str] = {}
    problem, values, names = fit.problem, fit.values, fit.coordinates.single
    gap, joint = problem.gap, problem.joint
    ratio = gap.robot.table.joint[joint].actuator.gear_ratio if problem.side == "motor" else 1.0
    velocity = gap.motion.velocity[:, joint]
    forward = float(np.mean(velocity[np.abs(velocity) > gap.doubt_speed[joint]] > 0.0))
    if min(forward, 1.0 - forward) < BACKWARD:
        levels = [name for name in names if fit.law.parameter(name).unit == "{force}"]
        out |= dict.fromkeys(levels, "not told from the effort's zero by motion one way only: record both directions")
    if "stribeck_velocity" in values:
        # exp(−(v/v_s)^δ) is the share of the fading level that is left.
        exponent = scalar(values, "stribeck_exponent") if "stribeck_exponent" in values else 1.0
        fallen = scalar(values, "stribeck_velocity") * (-math.log(1.0 - FALLEN)) ** (1.0 / exponent)
        if abs(ratio) * gap.motion.top_speed[joint] < fallen:
            out |= dict.fromkeys(BEYOND.intersection(names), FASTER)
    return out
