"""Causes that are no findings and that an extended robot does not need, or that explain nothing where they are."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mjfriction.diagnose.fit.as_little import leaves_as_little
from mjfriction.diagnose.fit.model import Model
from mjfriction.diagnose.search.stroke_curve import ALONG_STROKE, FRICTION_ALONG_STROKE
from mjfriction.diagnose.settle.stated import Settled
from mjfriction.diagnose.tell.left_over import LeftOver, left_over
from mjfriction.diagnose.tell.untold import Untold


def spared(settled: Settled) -> tuple[Settled, LeftOver]:
    """Return a settled model without needless causes (:func:`without_needless`), and without those that explain nothing
    (:func:`told_alone`), and what it leaves.

    Needless causes stay where without them something would no longer be told to be unexplained: a curve along a stroke
    is seen by the causes that approximate it.
    """
    over = left_over(settled)
    less = without_needless(settled, over.untold)
    if less is not settled:
        then = left_over(less, untold=over.untold.keys)
        lost = {one.joint for one in over.remaining} - {one.joint for one in then.remaining}
        settled, over = (settled, over) if lost else (less, then)
    return told_alone(settled, over)


def told_alone(settled: Settled, over: LeftOver) -> tuple[Settled, LeftOver]:
    """Return a settled model without the causes that are no findings at joints where something is left unexplained.

    There they stand in for what no cause explains, along the recorded motion only: on another motion a spring that
    bends like a hose goes on bending, and a step comes at a time of its own.  Without them a finding may hardly show
    beside what is left, and goes too.  What was told to be unexplained stays told; of a curve along a stroke the share
    was taken without the causes that approximate it.
    """
    open_joints = {settled.model.gap.robot.joints.index(one.joint) for one in over.remaining}
    less = settled.model
    for choice, fitted in settled.model.fitted_causes:
        local = choice.site.joint in open_joints and not choice.cause.whole_arm
        usual = choice.cause.usual(less.gap, choice.site, fitted)
        less = less.without(choice) if local and not usual and choice.key in over.untold.keys else less
    if less is settled.model:
        return settled, over
    without = replace(settled, model=less)
    then = left_over(without, untold=over.untold.keys)
    curves = {one.joint: one for one in over.remaining if one.covariate in (ALONG_STROKE, FRICTION_ALONG_STROKE)}
    now = {one.joint: one for one in then.remaining} | curves
    remaining = tuple(now.pop(one.joint, one) for one in over.remaining) + tuple(now.values())
    return told_alone(without, replace(then, remaining=remaining))


def without_needless(settled: Settled, untold: Untold) -> Settled:
    """Return a settled model without causes that are not reported and without which it leaves as little everywhere.

    Such a cause may cancel with a level or another cause along the recorded motion only: with joints that always move
    together, the friction of one and a coupling from the other.  On another motion it then does harm.  They go one by
    one, the least missed first.
    """
    model = settled.model
    while (less := _without_least(model, settled.model, untold)) is not None:
        model = less
    return settled if model is settled.model else replace(settled, model=model)


def _without_least(model: Model, whole: Model, untold: Untold) -> Model | None:
    without = [model.without(choice) for choice in model.chosen if choice.key in untold.keys]
    as_good = [less for less in without if leaves_as_little(less, whole)]
    return min(as_good, key=lambda less: float(np.sum(less.heldout_errors)), default=None)
