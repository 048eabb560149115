"""What there is to tell of a settled model: each of its causes and levels, with its sizes and the model without it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from mjfriction.diagnose.intervals import HalfWidths
from mjfriction.diagnose.model import Chosen, Model
from mjfriction.diagnose.one_transmission import parts_of_drives
from mjfriction.diagnose.stated import Settled
from mjfriction.diagnose.untold import Untold, without_cause
from mjfriction.identify.fitted import Fitted
from mjfriction.identify.gap import Gap
from mjfriction.record.log import Floats


@dataclass(frozen=True)
class ToTell:
    """One of them: what was chosen, its ``strengths`` and ``parameters``, and the model ``without`` it."""

    choice: Chosen
    without: Model
    strengths: Floats
    parameters: tuple[Fitted, ...]


def to_tell(settled: Settled, untold: Untold, widths: HalfWidths) -> Iterator[ToTell]:
    """Go through what a settled model has that is worth telling: what a transmission brings in two ways is told as one.

    ``untold`` tells which of its causes are no findings.
    """
    model, strengths = settled.model, settled.model.built
    named = [choice for choice in model.chosen if choice.key not in untold.keys]
    parts = parts_of_drives(named)
    fitted = {
        choice.key: tuple(_fitted(model.gap, choice, strengths[place], width))
        for choice, place, width in zip(model.chosen, model.places, widths.causes, strict=True)
    }
    places = {choice.key: place for choice, place in zip(model.chosen, model.places, strict=True)}
    for choice in named:
        if choice in parts.values():
            continue
        without, parameters, part = without_cause(model, choice), fitted[choice.key], parts.get(choice.key)
        if part is not None:
            without, parameters = without.without(part), (*parameters, *fitted[part.key])
        yield ToTell(choice, without, strengths[places[choice.key]], parameters)
    for choice in settled.levels:
        if choice.key in untold.keys:
            continue
        level = model.nuisance.of_level(choice.site.joint)
        told = tuple(_fitted(model.gap, choice, strengths[level], widths.nuisance[level]))
        yield ToTell(choice, without_cause(model, choice), strengths[level], told)


def _fitted(gap: Gap, choice: Chosen, strengths: Floats, half: Floats) -> list[Fitted]:
    sliding = gap.body.sliding[choice.site.joint]
    quantities = choice.cause.quantities(gap, choice.site)
    entries = [
        (quantity.parameter, quantity.shift + quantity.factor * value, abs(quantity.factor) * width)
        for quantity, value, width in zip(quantities, strengths, half[: len(quantities)], strict=True)
    ]
    entries += [
        (declared, value, width)
        for declared, value, width in zip(
            choice.cause.shape_parameters, choice.site.shape, half[len(quantities) :], strict=False
        )
    ]
    return [
        Fitted(
            name=declared.name,
            meaning=declared.meaning,
            unit=declared.unit_for(sliding=sliding),
            value=float(np.clip(value, declared.lower, declared.upper)),
            low=float(max(declared.lower, value - width)),
            high=float(min(declared.upper, value + width)),
        )
        for declared, value, width in entries
        if width > 0.0  # what the motion does not show at all has no interval
    ]
