"""The base parameters of freed links: combinations of their inertias that the motion shows to be off."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mjfriction.diagnose.fit.intervals import HalfWidths
from mjfriction.diagnose.fit.model import Model
from mjfriction.identify.fitted import Fitted


@dataclass(frozen=True)
class BaseChanges:
    """The combinations that the motion shows to be off, the best determined first, each as stated and as fitted.

    ``shown`` is the number of combinations that the motion shows at all.
    """

    off: tuple[tuple[float, Fitted], ...]
    shown: int


def base_changes(model: Model, widths: HalfWidths) -> BaseChanges:
    """Return which combinations of the freed links' inertias are off by more than their 95 % intervals; none where no
    link was freed.
    """
    robot, inertias, place = model.gap.robot, model.nuisance.inertias, model.nuisance.of_inertias
    if inertias is None:
        return BaseChanges((), 0)
    normal = model.system.normal
    gram = normal.products.whole[0][place, place]
    # The prior pulls links towards the stated values. The bias is as large as those are off, and the noise does not
    # show it, so add the prior's share of the covariance.
    drawn = normal.white_covariance(np.zeros(normal.joints))
    covariance = (widths.covariance + drawn[: model.nuisance.count, : model.nuisance.count])[place, place]
    stated, fitted = (
        inertias.fitted(one, gram, covariance, widths.quantile)
        for one in (robot, inertias.applied(robot, model.built[place]))
    )
    pairs = [(before.value, now) for before, now in zip(stated, fitted, strict=True)]
    return BaseChanges(tuple(pair for pair in pairs if not pair[1].low <= pair[0] <= pair[1].high), len(pairs))
