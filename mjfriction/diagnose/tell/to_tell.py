"""What a settled model reports: each of its causes and levels, with its fitted values and the model without it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from mjfriction.diagnose.causes.rotor_inertia import RotorInertia
from mjfriction.diagnose.fit.intervals import HalfWidths
from mjfriction.diagnose.fit.model import Chosen, Model
from mjfriction.diagnose.fit.sensor_scale import sensor_factors
from mjfriction.diagnose.search.one_transmission import parts_of_drives
from mjfriction.diagnose.settle.stated import Settled
from mjfriction.diagnose.tell.untold import Untold, without_cause
from mjfriction.identify.fitted import Fitted
from mjfriction.identify.gap import Gap
from mjfriction.record.log import Floats


@dataclass(frozen=True)
class ToTell:
    """A cause or level to report.

    ``choice`` is the cause at its site, ``strengths`` and ``parameters`` are as the extended robot states them,
    ``places`` are those of its strengths in the model, and ``without`` is a model that lacks it.
    """

    choice: Chosen
    places: tuple[slice, ...]
    without: Model
    strengths: Floats
    parameters: tuple[Fitted, ...]


def to_tell(settled: Settled, untold: Untold, widths: HalfWidths) -> Iterator[ToTell]:
    """Yield the causes and levels of a settled model that are findings; all parts of one transmission are one of them.

    ``untold`` says which of the model's causes are no findings.
    """
    model = settled.model
    factors = sensor_factors(model, model.built)
    strengths = model.built / factors
    named = [choice for choice in model.chosen if choice.key not in untold.keys]
    parts = parts_of_drives(model, named)
    belonging = {part.key for own in parts.values() for part in own}
    fitted = {
        choice.key: tuple(_fitted(model.gap, choice, strengths[place], _built(width, factors[place])))
        for choice, place, width in zip(model.chosen, model.places, widths.causes, strict=True)
    }
    places = {choice.key: place for choice, place in zip(model.chosen, model.places, strict=True)}
    for choice in named:
        if choice.key in belonging:
            continue
        without, parameters = without_cause(model, choice), fitted[choice.key]
        for part in parts.get(choice.key, ()):
            without = without.without(part)
            # A rotor's parameter does not name its joint, and that of the drive is reported already.
            parameters += () if isinstance(part.cause, RotorInertia) else fitted[part.key]
        own = places[choice.key]
        of_parts = (places[part.key] for part in parts.get(choice.key, ()))
        yield ToTell(choice, (own, *of_parts), without, strengths[own], parameters)
    for choice in settled.levels:
        if choice.key in untold.keys:
            continue
        level = model.nuisance.of_level(choice.site.joint)
        told = tuple(_fitted(model.gap, choice, strengths[level], widths.nuisance[level] / factors[level]))
        yield ToTell(choice, (level,), without_cause(model, choice), strengths[level], told)


def _built(half: Floats, factors: Floats) -> Floats:
    # Half-widths of a cause's strengths as the robot file states them, followed by those of its shape parameters.
    return np.concatenate([half[: factors.size] / factors, half[factors.size :]])


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
        if width > 0.0  # a value that the motion does not excite at all has no interval
    ]
