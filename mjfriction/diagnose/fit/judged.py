"""The rows on which a model is judged."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mjfriction.diagnose.fit.model import Model
from mjfriction.identify.gap import Gap


def judged(*models: Model) -> Gap:
    """Return the gap of models of one log, with those rows clear in which it is known what each of their causes brings.

    While a joint rests, its motion does not reveal how much of its friction it holds, and another joint may carry that.
    """
    gap = models[0].gap
    clear = gap.clear.copy()
    for choice in (choice for model in models for choice in model.chosen):
        for joint, known in choice.cause.known_where(gap, choice.site).items():
            both = clear[:, joint] & known
            if np.any(both):
                clear[:, joint] = both
    return gap if np.all(clear == gap.clear) else replace(gap, clear=clear)
