"""A law's static parameters from a friction map: by nonlinear least squares, or as in the manipulator paper."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import OptimizeResult, least_squares
from scipy.stats import t as student

from mjfriction.errors import LogError
from mjfriction.identify.coordinates import Coordinates
from mjfriction.identify.friction_map import FrictionMap
from mjfriction.identify.problem import Side
from mjfriction.identify.starts import DYNAMIC, LEFT_AS_DECLARED, Usual, starts
from mjfriction.laws.ambient import ambient
from mjfriction.laws.arctan import ARCTAN
from mjfriction.laws.law import Floats, Law

MOST_LEVERAGE = 0.999  # highest leverage of a speed; with 1, a fit would follow it wherever it lies
FIRST_SAMPLES = 5  # points of a map through which the cubic near zero is fitted
FADING_STARTS = 7  # speeds to start from at which a level may fall, between the slowest and the fastest of a map
FIRST_ROUNDS, MOST_ROUNDS = 20, 400  # rounds of the fit from every start, and then from the best of them
TOLERANCE = 1e-10  # relative, of the fit


@dataclass(frozen=True)
class MapFit:
    """A law's static values on its side, their 95 % half-widths by name, and the RMS residual of the map (N·m, N).

    ``missed`` (k,) is the error at each speed if it were left out (to first order).
    """

    law: Law
    values: dict[str, float]
    half: dict[str, float]
    rms: float
    missed: Floats


def fit_map(points: FrictionMap, law: Law, side: Side, gear_ratio: float) -> MapFit:
    """Fit a law's static parameters to a map, every point weighted by its own error.

    Half-widths come from the points' scatter about the curve (Student's t), but never less than from the points' own
    errors.  Raises :class:`LogError` unless the map has more speeds than the law has static parameters.
    """
    speed, friction, error = on_side(points, side, gear_ratio)
    usual = _usual(speed, friction, float(np.max(points.load)) / _ratio(side, gear_ratio))
    fading = np.geomspace(2.0 * speed[0], 0.5 * speed[-1], FADING_STARTS) / usual.speed
    begin = starts(law, usual, fading.tolist())
    names = static_names(law)
    if speed.size <= len(names):
        raise LogError(
            f"law '{law.name}' has {len(names)} static parameters, and the passes have {speed.size} speeds; "
            f"record at least {len(names) + 1} speeds, or identify a law with fewer parameters"
        )
    coordinates = Coordinates(law, names, {name: value for name, value in begin[0].items() if name not in names})
    around = ambient(speed.size, load=points.load / _ratio(side, gear_ratio))

    def missed(x: Floats) -> Floats:
        return (friction - law.along(speed, around, law.pack(coordinates.values(x)))) / error

    def fitted(start: Floats, rounds: int) -> OptimizeResult:
        bounds = coordinates.bounds()
        inside = np.clip(start, *bounds)
        return least_squares(
            missed, inside, bounds=bounds, x_scale="jac", max_nfev=rounds, xtol=TOLERANCE, ftol=TOLERANCE
        )

    first = min((fitted(coordinates.vector(start), FIRST_ROUNDS) for start in begin), key=lambda found: found.cost)
    found = fitted(first.x, MOST_ROUNDS)
    x, slopes, left = np.asarray(found.x), np.asarray(found.jac), np.asarray(found.fun)
    freedoms = speed.size - x.size
    scatter = max(1.0, float(np.sum(np.square(left))) / freedoms)
    covariance = scatter * np.linalg.pinv(slopes.T @ slopes)
    turned = coordinates.slopes(x)
    deviation = np.sqrt(np.maximum(np.diag(turned @ covariance @ turned.T), 0.0))
    half = dict(zip(names, (deviation * float(student.ppf(0.975, freedoms))).tolist(), strict=True))
    rms = float(np.sqrt(np.mean(np.square(left * error))))
    basis = np.linalg.qr(slopes)[0]
    leverage = np.minimum(np.sum(np.square(basis), axis=1), MOST_LEVERAGE)
    return MapFit(law, {**coordinates.fixed, **coordinates.told(x)}, half, rms, left * error / (1.0 - leverage))


def static_names(law: Law) -> tuple[str, ...]:
    """Return the parameters of a law that passes at constant speed determine."""
    nominal = Usual(level=1.0, damping=1.0, speed=1.0, stroke=1.0, load=1.0)
    return tuple(name for name in starts(law, nominal)[0] if name not in LEFT_AS_DECLARED | DYNAMIC)


def arctan_procedure(points: FrictionMap, side: Side, gear_ratio: float) -> MapFit:
    """Fit law (14) as the paper does: δ from the slope near zero, the rest linear in it.

    The slope is that of a cubic through the first points, at the slowest of them.  τ_sc is roughly the least friction
    less the one at the slowest speed, where it is greatest.  δ is the slope over τ_sc (15–16), too small by a factor of
    2/π at least, because the arctangent term falls by π/2 of τ_sc.  Then θ = (τ_s, τ_sc, τ_v, τ_nlv) follows by least
    squares, θ = (ΦᵀΦ)⁻¹ΦᵀT (the paper's (21) prints the first factor as (ΦΦᵀ)⁻¹).

    Raises :class:`LogError` where the map does not fall from its slowest speed, or has fewer than six speeds.
    """
    speed, friction, _ = on_side(points, side, gear_ratio)
    if speed.size < 6:
        raise LogError(f"law 'arctan' by the slope near zero needs at least six speeds, not {speed.size}; record more")
    cubic = np.polynomial.Polynomial.fit(speed[:FIRST_SAMPLES], friction[:FIRST_SAMPLES], 3)
    slope = float(cubic.deriv()(speed[0]))
    fall = float(np.min(friction) - friction[0])
    if slope >= 0.0 or fall >= 0.0:
        raise LogError(
            "law 'arctan' by the slope near zero: friction does not fall from the slowest speed on; "
            "record slower passes, or identify a law without a Stribeck part"
        )
    steepness = slope / fall
    phi = np.column_stack([np.ones_like(speed), np.arctan(steepness * speed), speed, speed**2])
    theta = np.linalg.lstsq(phi, friction, rcond=None)[0]
    names = ("static", "stribeck_fall", "viscous", "viscous_bend")
    values = {**dict(zip(names, theta.tolist(), strict=True)), "stribeck_steepness": steepness, "sign_sharpness": 1e9}
    left = friction - phi @ theta
    return MapFit(ARCTAN, values, {}, float(np.sqrt(np.mean(np.square(left)))), left)


def on_side(points: FrictionMap, side: Side, gear_ratio: float) -> tuple[Floats, Floats, Floats]:
    """Return speed, friction and its error on a side of the gear."""
    ratio = _ratio(side, gear_ratio)
    return points.speed * ratio, points.friction / ratio, points.error / ratio


def _ratio(side: Side, gear_ratio: float) -> float:
    return abs(gear_ratio) if side == "motor" else 1.0


def _usual(speed: Floats, friction: Floats, load: float) -> Usual:
    level = float(np.median(friction))
    rise = float((friction[-1] - np.min(friction)) / max(speed[-1] - speed[int(np.argmin(friction))], 1e-9 * speed[-1]))
    return Usual(
        level=max(level, 1e-9),
        damping=max(rise, 1e-3 * level / speed[-1]),
        speed=float(speed[-1]),
        stroke=1.0,
        load=load,
    )
