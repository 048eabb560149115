"""Confidence intervals: how well the data determine each fitted quantity."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from scipy.stats import t as student

from mjfriction.diagnose.fit.exact import stated_exactly
from mjfriction.diagnose.fit.model import Chosen, Model, build_model, cause_block
from mjfriction.diagnose.fit.nearness import NEAREST, nearness_of
from mjfriction.diagnose.fit.nuisance import make_nuisance
from mjfriction.identify.normal import Normal
from mjfriction.identify.regression import Columns, System
from mjfriction.record.log import Floats

STEP = 0.05  # of a shape parameter's search step: the step of the difference quotient for its tangent
LEAST_KNOWN = 100.0  # prior standard deviation of a shape parameter, in search steps: next to no restraint


@dataclass(frozen=True)
class HalfWidths:
    """Half-widths of 95 % intervals: of the nuisance strengths, and of each chosen cause's strengths, then its shape
    parameters.

    A half-width is ``quantile`` standard deviations; ``covariance`` is that of the nuisance strengths.
    """

    nuisance: Floats
    causes: tuple[Floats, ...]
    covariance: Floats
    quantile: float


def half_widths(model: Model) -> HalfWidths:
    """Return how uncertain everything fitted is, from the clustered covariance.

    Shape parameters enter linearised, so that the uncertainties of, say, a level and the speed over which it fades are
    joint ones. Where the motion repeats, the repetitions are the clusters.
    """
    full, sizes = _with_shapes(model)
    return _half_widths(model, sizes, full.covariance(model.gap.blocks.group), model.nuisance.count)


def widths_told(model: Model) -> HalfWidths:
    """Return how uncertain the reported values of a model are.

    The interval of a moment ends where the fit is worse by what 95 % allow. The intervals of causes are widened by as
    much as errors of the stated drives and links would move them, unless all is stated exactly or links are freed.
    These errors are taken to be as large as this robot's refitted ones, or, where all are held as stated, the smallest
    that are assumed. A fit leans towards its prior, and no row of the log shows how wrong the prior is.
    """
    own, nuisance = half_widths(model), model.nuisance
    causes = zip(model.chosen, own.causes, strict=True)
    own = replace(own, causes=tuple(_flat(model, choice, half, own.quantile) for choice, half in causes))
    if stated_exactly(model) or nuisance.inertias is not None:
        return own
    usual, near = make_nuisance(model.gap, drives=True), nearness_of(model)
    doubted = replace(nuisance, drives=nuisance.drives or usual.drives, links=nuisance.links or usual.links)
    full, sizes = _with_shapes(build_model(model.gap, doubted, model.chosen))
    full = full.tighter(doubted.of_stated, (near.spread if near.shown else NEAREST) ** -2)
    covariance = full.covariance(model.gap.blocks.group) + full.leaning(doubted.of_stated)
    wider = zip(own.causes, _half_widths(model, sizes, covariance, doubted.count).causes, strict=True)
    return replace(own, causes=tuple(np.maximum(half, more) for half, more in wider))


def _flat(model: Model, choice: Chosen, half: Floats, quantile: float) -> Floats:
    # Rows beside a step are left out where they fit neither side of it, and then the fit is as good at any moment among
    # them: no tangent at one of them shows that.
    shape, finest = np.array(choice.site.shape), choice.cause.shape_resolution(model.gap, choice.site)
    if not any(finest):
        return half
    felt, weight = sorted(cause_block(model.gap, choice)[0]), model.system.rows.weight
    system = model.without(choice).system.reweighted(weight, felt)

    def gain(moved: Floats) -> float:
        columns = choice.cause.columns(model.gap, choice.site.shaped(tuple(moved.tolist())))
        return float(system.screen({joint: values[:, None, :] for joint, values in columns.items()})[1][0])

    bounds = choice.cause.shape_bounds(model.gap, choice.site)
    left = (model.residual() * weight)[:, felt][model.gap.clear[:, felt]]
    wide, least = half.copy(), gain(shape) - quantile**2 * float(np.mean(np.square(left)))
    for k, (fine, (low, high)) in enumerate(zip(finest, bounds, strict=True)):

        def as_good(steps: int, k: int = k, fine: float = fine, low: float = low, high: float = high) -> bool:
            moved = shape + steps * fine * np.eye(shape.size)[k]
            return low < moved[k] < high and gain(moved) > least

        place = half.size - shape.size + k
        reach = max(_first_worse(as_good, 1), _first_worse(as_good, -1))
        wide[place] = max(wide[place], reach * fine)
    return wide


def _first_worse(as_good: Callable[[int], bool], way: int) -> int:
    # The number of steps, to one side, after which it is no longer as good.
    near, far = 0, 1
    while as_good(way * far):
        near, far = far, 2 * far
    while far - near > 1:
        middle = (near + far) // 2
        near, far = (middle, far) if as_good(way * middle) else (near, middle)
    return far


def _with_shapes(model: Model) -> tuple[Normal, list[int]]:
    # The normal equations of a model whose shapes may move too, and how many strengths and shapes each cause has.
    nuisance, strengths = model.nuisance, model.strengths
    columns, precisions = [nuisance.columns], [model.known_of_nuisance]
    sizes = []
    for choice, place in zip(model.chosen, model.places, strict=True):
        own, precision = cause_block(model.gap, choice)
        tangents, tangent_precision = _tangents(model, choice, own, strengths[place])
        columns = [*columns, {joint: np.hstack([own[joint], tangents[joint]]) for joint in own}]
        precisions = [*precisions, np.concatenate([precision, tangent_precision])]
        sizes.append(precision.size + tangent_precision.size)
    return System(model.system.rows, columns, precisions).normal, sizes


def _half_widths(model: Model, sizes: list[int], covariance: Floats, count: int) -> HalfWidths:
    # The first ``count`` strengths of the covariance are the nuisances'.
    gap = model.gap
    quantile = float(student.ppf(0.975, gap.blocks.groups - 1))
    half = quantile * np.sqrt(np.maximum(np.diag(covariance), 0.0))
    ends = count + np.cumsum([0, *sizes])
    for choice, end in zip(model.chosen, ends[1:], strict=True):
        finest = choice.cause.shape_resolution(gap, choice.site)
        half[end - len(finest) : end] = np.maximum(half[end - len(finest) : end], finest)
    of_causes = tuple(half[a:b] for a, b in itertools.pairwise(ends))
    return HalfWidths(half[:count], of_causes, covariance[:count, :count], quantile)


def _tangents(model: Model, choice: Chosen, own: Columns, strengths: Floats) -> tuple[Columns, Floats]:
    shape, steps = choice.site.shape, choice.cause.shape_steps(model.gap, choice.site)
    parts: dict[int, list[Floats]] = {joint: [] for joint in own}
    for change in np.diag(STEP * np.array(steps)):
        sites = [choice.site.shaped(tuple((np.array(shape) + sign * change).tolist())) for sign in (-1.0, 1.0)]
        less, more = (choice.cause.columns(model.gap, site) for site in sites)
        for joint in own:
            parts[joint].append((more[joint] - less[joint]) @ strengths / (2.0 * float(np.sum(change))))
    rows = model.gap.blocks.row.size
    tangents = {joint: np.column_stack(found) if found else np.zeros((rows, 0)) for joint, found in parts.items()}
    return tangents, np.array([1.0 / (LEAST_KNOWN * step) ** 2 for step in steps])
