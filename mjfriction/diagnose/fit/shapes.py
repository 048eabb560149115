"""Search for the best shapes of causes, such as the speed over which a level fades or the period of a wave."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace

import numpy as np
from scipy.optimize import minimize

from mjfriction.diagnose.causes.cause import Site
from mjfriction.diagnose.fit.model import Chosen, Model, build_model
from mjfriction.diagnose.fit.trial import try_out
from mjfriction.identify.regression import Columns
from mjfriction.record.log import Floats

Bounds = Sequence[tuple[float, float]]
# Squared error, over the noise, by which the best of two shape parameters does better by chance once in a hundred.
BY_CHANCE = 9.0


def best_shape(model: Model, choice: Chosen, bounds: Bounds | None = None) -> Chosen:
    """Return a cause, not part of the model, with the shape that reduces the model's residual most.

    ``bounds`` are those of the cause if not given.
    """

    def lost(site: Site, columns: Columns | None = None) -> float:
        return -_taken_off(model, replace(choice, site=site), columns)

    around, best = choice.cause.around_sites(model.gap, choice.site), choice.site
    if around:
        least = lost(best)
        for _ in range(choice.cause.around_rounds):
            every = choice.cause.columns_of(model.gap, around)
            losses = [lost(site, columns) for site, columns in zip(around, every, strict=True)]
            if min(losses) >= least:
                break
            least, best = min(losses), around[int(np.argmin(losses))]
            around = choice.cause.around_sites(model.gap, best)
        return Chosen(choice.cause, best)
    bounds = choice.cause.shape_bounds(model.gap, choice.site) if bounds is None else bounds
    if not bounds:
        return choice

    relative = choice.cause.relative_shape

    def shape_at(x: Floats) -> tuple[float, ...]:
        # Mirrored at the limits: if all that lies beyond one were that limit, the simplex would collapse onto it.
        low, high = limits.T
        within = np.clip(high - np.abs(high - low - np.abs(x - low)), low, high)
        return tuple((np.exp(within) if relative else first + within).tolist())

    def loss(x: Floats) -> float:
        return lost(choice.site.shaped(shape_at(x)))

    # A shape that is not relative, such as a moment, is searched as an offset from its start value, because clocks may
    # start at any number of seconds.
    first, limits = np.clip(choice.site.shape, *np.array(bounds).T), np.array(bounds)
    steps = np.asarray(choice.cause.shape_steps(model.gap, choice.site))
    if relative:
        start, limits, steps = np.log(first), np.log(limits), np.log1p(steps / choice.site.shape)
    else:
        start, limits = np.zeros(first.size), limits - first[:, None]
    simplex = np.vstack([start, start + np.diag(steps)])
    options = {"maxfev": 60, "xatol": 1e-2 * float(np.min(steps)), "initial_simplex": simplex}
    found = minimize(loss, start, method="Nelder-Mead", options=options)
    return Chosen(choice.cause, choice.site.shaped(shape_at(found.x))) if found.fun < loss(start) else choice


def own_shape(model: Model, choice: Chosen) -> Chosen | None:
    """Return a cause, not part of the model, with the best shape that is its own; None where there is none.

    Where the best of all shapes belongs to something else, a usual one of the cause is its own if it does as well but
    for chance.
    """
    best = best_shape(model, choice)
    if not choice.cause.own_shape(model.gap, best.site):
        usual = choice.cause.usual_bounds(model.gap, choice.site)
        if not usual:
            return None
        most, best = _taken_off(model, best), best_shape(model, choice, usual)
        if _taken_off(model, best) < most - BY_CHANCE or not choice.cause.own_shape(model.gap, best.site):
            return None
    return best if apart(model, best) else None


def _taken_off(model: Model, choice: Chosen, columns: Columns | None = None) -> float:
    # The squared error, over the noise, that a cause takes off a model; none where it is not physical.  Columns that
    # were computed around a strength hold there, whatever strength fits them best.
    columns = choice.cause.columns(model.gap, choice.site) if columns is None else columns
    fitted, gains = model.system.screen({joint: values[:, None, :] for joint, values in columns.items()})
    strengths, gain = fitted[0], float(gains[0])
    if choice.site.around and gain > 0.0:
        gain *= 1.0 - (1.0 - choice.site.around / float(strengths[0])) ** 2
        strengths = np.array([choice.site.around])
    return gain if choice.cause.admissible(model.gap, choice.site, strengths) else 0.0


def apart(model: Model, choice: Chosen) -> bool:
    """Return whether the motion tells a cause apart from the model's causes of the same kind on the same joint."""
    return all(
        choice.cause.apart(model.gap, choice.site, other.site)
        for other in model.chosen
        if (other.cause.name, other.site.joint) == (choice.cause.name, choice.site.joint)
    )


def reshaped(model: Model, joints: Collection[int] | None = None) -> Model:
    """Return the model with the shapes of its causes (only those on ``joints``, if given) searched again, one by one.

    A new cause, or a level that is now held, moves the best shapes of other causes on the joints that feel it.  A cause
    keeps its present shape if the new one is not physical, belongs to a different cause, or is not told apart from that
    of another cause of its kind.
    """
    for i, choice in enumerate(model.chosen):
        mine = joints is None or choice.site.joint in joints
        if (choice.site.shape or choice.site.around) and not choice.tangent and mine:
            without = model.without(choice)
            better = own_shape(without, choice)
            if better is not None and try_out(without, better) is not None:
                model = build_model(model.gap, model.nuisance, (*model.chosen[:i], better, *model.chosen[i + 1 :]))
    return model
