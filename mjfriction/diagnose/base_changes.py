"""What links that were let go come to: the combinations of their inertias that the motion shows to be off."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mjfriction.diagnose.intervals import HalfWidths
from mjfriction.diagnose.model import Model
from mjfriction.identify.fitted import Fitted


@dataclass(frozen=True)
class BaseChanges:
    """The combinations that the motion shows to be off, those that show most first, each as stated and as fitted;
    ``shown`` is how many it shows at all.
    """

    off: tuple[tuple[float, Fitted], ...]
    shown: int


def base_changes(model: Model, widths: HalfWidths) -> BaseChanges:
    """Return which combinations of the inertias of links that were let go are off by more than their 95 % intervals;
    none where no link was let go.
    """
    robot, inertias, place = model.gap.robot, model.nuisance.inertias, model.nuisance.of_inertias
    if inertias is None:
        return BaseChanges((), 0)
    normal = model.system.normal
    gram = normal.products.whole[0][place, place]
    # What is known beforehand draws links to what is stated, by as much as that is off: no noise shows it.
    drawn = normal.white_covariance(np.zeros(normal.joints))
    covariance = (widths.covariance + drawn[: model.nuisance.count, : model.nuisance.count])[place, place]
    stated, fitted = (
        inertias.fitted(one, gram, covariance, widths.quantile)
        for one in (robot, inertias.applied(robot, model.built[place]))
    )
    pairs = [(before.value, now) for before, now in zip(stated, fitted, strict=True)]
    return BaseChanges(tuple(pair for pair in pairs if not pair[1].low <= pair[0] <= pair[1].high), len(pairs))
