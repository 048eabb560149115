"""What a bristle adds to a law's static parameters, from the error of the friction simulated along a motion.

The order is that of the manipulator paper (Indri and others, section IV): the static parameters from passes are held
while the bristle is fitted.  Then everything is fitted together, to the motion and to the passes.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.optimize import OptimizeResult, least_squares
from scipy.stats import t as student

from mjfriction.identify.coordinates import Coordinates
from mjfriction.identify.friction_map import FrictionMap
from mjfriction.identify.map_fit import MapFit, on_side
from mjfriction.identify.problem import Side
from mjfriction.laws.ambient import ambient
from mjfriction.laws.law import Floats, Law

TRAVELS = np.geomspace(1e-7, 1e-1, 13)  # rad or m: level over stiffness, to start from
RELAXED = (1e-3, 5e-3, 2.5e-2)  # s: σ₁ over σ₀, to start from
STARTS = 4  # the best of these, from which fits start
MOST_ROUNDS = 60
DIFFERENCE = 1e-4  # step for slopes, as a share of a coordinate
# Share of the most that a combination of parameters can show, below which its interval grows no further.
UNTOLD = 1e-10
BRISTLE = ("bristle_stiffness", "bristle_damping")


@dataclass(frozen=True)
class BristleFit:
    """A law with a bristle, on its side of the gear.

    ``values`` has the static parameters held, and ``together`` has everything fitted together; ``half`` are the 95 %
    half-widths of the latter by name.  ``rms`` is what is left of the motion's friction: with the static parameters
    alone, with the bristle, and with everything fitted together.
    """

    law: Law
    values: dict[str, float]
    together: dict[str, float]
    half: dict[str, float]
    rms: tuple[float, float, float]


def fit_bristle(
    law: Law,
    statics: MapFit,
    points: FrictionMap,
    side: Side,
    gear_ratio: float,
    speed: Floats,
    friction: Floats,
    step: float,
) -> BristleFit:
    """Fit a law's bristle, its stiffness and damping, to the ``friction`` (n,) along a motion of ``speed`` (n,).

    Both are on the law's side; samples lie ``step`` seconds apart.  ``statics`` are the static parameters of the law's
    sibling, fitted to the passes ``points``.  Half-widths count as many independent errors as the motion has turns and
    the passes have speeds, because what a law leaves of a motion is coloured.
    """
    names = [parameter.name for parameter in law.parameters]
    around = ambient(speed.size)
    of_pass, level, error = on_side(points, side, gear_ratio)
    at_passes = ambient(of_pass.size)
    held = {name: value for name, value in statics.values.items() if name in names}

    def missed(values: dict[str, float]) -> Floats:
        return friction - law.follow(speed, around, step, law.pack(values))[0]

    travels = float(np.max(np.abs(friction))) / TRAVELS
    begin = [{**held, **dict(zip(BRISTLE, (k, k * s), strict=True))} for k in travels.tolist() for s in RELAXED]
    errors = np.array([_rms(missed(values)) for values in begin])
    alone = Coordinates(law, BRISTLE, held)
    tried = [_fitted(alone, begin[k], missed) for k in np.argsort(errors, kind="stable")[:STARTS]]
    found = alone.told(min(tried, key=lambda fit: fit.cost).x)
    left = _rms(missed({**held, **found}))
    stiff = dict(zip(BRISTLE, (float(travels[0]), 0.0), strict=True))
    turns = max(2, int(np.count_nonzero(np.diff(np.sign(speed)))))
    # A motion's thousands of samples say no more than its turns do, so weight passes and motion by what each is worth.
    weigh = np.sqrt(turns / speed.size) / left

    def both(values: dict[str, float]) -> Floats:
        told = law.along(of_pass, at_passes, law.pack(values))
        return np.concatenate([weigh * missed(values), (level - told) / np.maximum(error, statics.rms)])

    whole = Coordinates(law, tuple(names), {})
    last = _fitted(whole, {**held, **found}, both)
    together = whole.told(last.x)
    freedoms = max(1, turns + of_pass.size - len(names))
    scatter = max(1.0, 2.0 * float(last.cost) / freedoms)
    turned = whole.slopes(last.x)
    shown = np.linalg.norm(last.jac, axis=0)
    size = np.maximum(shown, UNTOLD * np.max(shown))
    gram = (last.jac / size).T @ (last.jac / size) + UNTOLD * np.eye(size.size)
    spread = scatter * (turned / size) @ np.linalg.inv(gram) @ (turned / size).T
    half = float(student.ppf(0.975, freedoms)) * np.sqrt(np.maximum(np.diag(spread), 0.0))
    rms = (_rms(missed({**held, **stiff})), left, _rms(missed(together)))
    return BristleFit(law, {**held, **found}, together, dict(zip(together, half.tolist(), strict=True)), rms)


def _fitted(
    coordinates: Coordinates, start: dict[str, float], left: Callable[[dict[str, float]], Floats]
) -> OptimizeResult:
    bounds = coordinates.bounds()
    begin = np.clip(coordinates.vector(start), np.nextafter(bounds[0], np.inf), np.nextafter(bounds[1], -np.inf))

    def values(x: Floats) -> dict[str, float]:
        return {**coordinates.fixed, **coordinates.told(x)}

    return least_squares(
        lambda x: left(values(x)), begin, bounds=bounds, x_scale="jac", diff_step=DIFFERENCE, max_nfev=MOST_ROUNDS
    )


def _rms(values: Floats) -> float:
    return float(np.sqrt(np.mean(np.square(values))))
