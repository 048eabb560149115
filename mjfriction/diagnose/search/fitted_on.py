"""A model of one part of a log, fitted to another or to the whole of it."""

from __future__ import annotations

from dataclasses import replace

from mjfriction.diagnose.fit.model import Chosen, Model, build_model
from mjfriction.diagnose.fit.shapes import reshaped
from mjfriction.diagnose.fit.tangent import straightened
from mjfriction.diagnose.search.as_known import as_known
from mjfriction.identify.gap import Gap


def fitted_on(gap: Gap, model: Model) -> Model:
    """Return a model with its shapes and strengths fitted to a gap of the same log, unless they already are."""
    if model.gap.motion is gap.motion:
        return model
    chosen = tuple(map(untied, model.chosen))
    nuisance = model.nuisance.along(gap, model.nuisance.sources)
    return as_known(straightened(reshaped(build_model(gap, nuisance, chosen))))


def untied(choice: Chosen) -> Chosen:
    """Return a chosen cause, and those whose place it took, without tangents: these hold the rows of one gap."""
    return replace(choice, tangent=None, instead=tuple(map(untied, choice.instead)))
