"""What a fit does not say by its numbers: parameters at a bound, not fixed by the log, or not told apart."""

from __future__ import annotations

import itertools

import numpy as np

from mjfriction.identify.fit import LawFit
from mjfriction.record.log import Floats

ALIKE = 0.98  # correlation of two parameters past which only a combination of them is known
LOOSE = 1.0  # of a value, that its interval may be wide to either side before it is not fixed
UNSEEN = 1e-9  # of the friction's RMS, that a change of a parameter by itself must make
AT_BOUND = 1e-6  # of the coordinates' size
SHAPES = frozenset(
    {"bristle_stiffness", "bristle_damping", "stribeck_velocity", "stribeck_steepness", "stribeck_exponent"}
)


def notes(fit: LawFit, half: Floats, covariance: Floats) -> dict[str, str]:
    """Return a remark for every parameter that needs one, by name.

    ``half`` (told,) are the 95 % half-widths, ``covariance`` (told, told) that of the values.  Elements get none: of
    one by itself a log says little, of all together much.
    """
    low, high = fit.coordinates.bounds()
    names, values = fit.coordinates.single, fit.told
    out: dict[str, str] = {}
    seen = np.sqrt(np.mean(np.square(fit.slopes), axis=0)) * np.maximum(np.abs(fit.x), 1e-3)
    for k, name in enumerate(names):
        if seen[k] < UNSEEN * float(np.sqrt(np.mean(np.square(fit.problem.target)))):
            out[name] = "this log does not show it"
        elif half[k] > LOOSE * abs(values[name]) and name in SHAPES:
            out[name] = "not fixed by this log: slower motion with more reversals would show it"
        for bound, which in ((low[k], "lowest"), (high[k], "highest")):
            if np.isfinite(bound) and abs(fit.x[k] - bound) < AT_BOUND * (1.0 + abs(bound)):
                out[name] = f"at the {which} value allowed"
    deviation = np.sqrt(np.maximum(np.diag(covariance), 1e-300))
    correlation = covariance / np.outer(deviation, deviation)
    for a, b in itertools.combinations(range(len(names)), 2):
        if abs(correlation[a, b]) > ALIKE:
            for one, other in ((a, b), (b, a)):
                out.setdefault(names[one], f"not told from {names[other]} on this motion")
    return out
