"""Causes that are no findings and without which as little is left: an extended robot does not need them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mjfriction.diagnose.fit.as_little import leaves_as_little
from mjfriction.diagnose.fit.model import Model
from mjfriction.diagnose.settle.stated import Settled
from mjfriction.diagnose.tell.left_over import LeftOver, left_over
from mjfriction.diagnose.tell.untold import Untold


def spared(settled: Settled) -> tuple[Settled, LeftOver]:
    """Return a settled model without needless causes (:func:`without_needless`), and what it leaves.

    They stay where without them something would no longer be told to be unexplained: a curve along a stroke is seen by
    the causes that approximate it.
    """
    over = left_over(settled)
    less = without_needless(settled, over.untold)
    if less is settled:
        return settled, over
    then = left_over(less, untold=over.untold.keys)
    lost = {one.joint for one in over.remaining} - {one.joint for one in then.remaining}
    return (settled, over) if lost else (less, then)


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
