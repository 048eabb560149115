"""Causes give their places to what fits better there, now that others are known."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

from mjfriction.diagnose.causes.cause import Cause
from mjfriction.diagnose.field import Chances, Entrant, Field
from mjfriction.diagnose.model import Chosen, Model, partners
from mjfriction.diagnose.refusal import proved
from mjfriction.diagnose.short_list import contenders, fairly, passing
from mjfriction.diagnose.trial import Trial, try_out

MOST_EXCHANGED = 8  # causes of a model: of a longer list none is believed much, and each exchange takes a search anew

Kinds = tuple[tuple[type[Cause], int], tuple[type[Cause], int]]


@dataclass(frozen=True)
class Exchange:
    """A ``model`` in which one cause gave its place to another: ``kinds`` are what they are, and their joints."""

    model: Model
    kinds: Kinds


def for_place_of(choice: Chosen, field: Field) -> Field:
    """Return what of a field may stand in the place of a cause: what sits on its joint or is felt by the whole arm, and
    has another name, or counts apart from it; in that of one which the whole arm feels, what changes the links' loads
    from any joint.
    """
    kind = choice.cause.name, choice.cause.first_order

    def reaches(entrant: Entrant) -> bool:
        loads = choice.cause.whole_arm and entrant.cause.of_body
        return entrant.joint == choice.site.joint or entrant.cause.whole_arm or loads

    return tuple(
        entrant for entrant in field if reaches(entrant) and (entrant.cause.name, entrant.cause.first_order) != kind
    )


def in_place_of(without: Model, own: Trial, field: Field) -> tuple[Trial, list[Trial]]:
    """Return the trial of a cause that was taken out of a model, and those of the best of a field, compared fairly."""
    again, *rivals = fairly(without, [own, *contenders(without, field)])
    return again, rivals


def exchanged(
    model: Model, field: Field, chances: Chances, least: float, made: Collection[Kinds] = ()
) -> Exchange | None:
    """Return the exchange of one of a model's causes for another that beats it by the ``least`` merit in its place, now
    that the others are known; None where there is none but those that were ``made`` before.

    What was chosen first was chosen beside nothing: a load at the flange may have stood for a heavier first link and
    the rotor of the second joint together.  ``chances`` is how often chance might strike.
    """
    told = model.noteworthy
    if not 2 <= len(told) <= MOST_EXCHANGED:
        return None
    for choice in told:
        without = model.without(choice)
        own = try_out(without, choice)
        if own is None or partners(choice, without.chosen):
            continue
        narrower = tuple(one for one in for_place_of(choice, field) if not _wider(one, choice.cause))
        own, rivals = in_place_of(without, own, narrower)
        better = [rival for rival in passing(rivals, chances) if rival.merit > own.merit + least]
        for rival in sorted(better, key=lambda trial: -trial.merit):
            kinds = (_kind(choice), _kind(rival.chosen))
            if kinds in made:
                continue
            other = without.with_also(rival.chosen)
            if proved(other, rival.chosen):
                return Exchange(other, kinds)
    return None


def _kind(choice: Chosen) -> tuple[type[Cause], int]:
    return type(choice.cause), choice.site.joint


def _wider(entrant: Entrant, cause: Cause) -> bool:
    # What contains a cause takes its place where that pays, as its richer form.
    return cause.name in entrant.cause.contains
