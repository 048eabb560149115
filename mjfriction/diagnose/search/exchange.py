"""Exchange a chosen cause for one that fits better in its place once the other causes are known."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

from mjfriction.diagnose.causes.cause import Cause
from mjfriction.diagnose.fit.model import Chosen, Model, partners
from mjfriction.diagnose.fit.trial import Trial, try_out
from mjfriction.diagnose.search.field import Chances, Entrant, Field
from mjfriction.diagnose.search.refusal import proved
from mjfriction.diagnose.search.short_list import contenders, fairly, passing

# Most findings with which causes are exchanged: a longer list is hardly credible, and each exchange takes a new search.
MOST_EXCHANGED = 8

Kinds = tuple[tuple[type[Cause], int], tuple[type[Cause], int]]


@dataclass(frozen=True)
class Exchange:
    """A ``model`` in which one cause was exchanged for another; ``kinds`` are the types and joints of the two."""

    model: Model
    kinds: Kinds


def for_place_of(choice: Chosen, field: Field) -> Field:
    """Return the part of a field that may take the place of a cause.

    These are causes at its joint or felt by the whole arm; if the whole arm feels the cause itself, also causes at any
    joint that change the links' loads. Each has another name, or counts apart from the cause (``first_order``).
    """
    kind = choice.cause.name, choice.cause.first_order

    def reaches(entrant: Entrant) -> bool:
        loads = choice.cause.whole_arm and entrant.cause.of_body
        return entrant.joint == choice.site.joint or entrant.cause.whole_arm or loads

    return tuple(
        entrant for entrant in field if reaches(entrant) and (entrant.cause.name, entrant.cause.first_order) != kind
    )


def in_place_of(without: Model, own: Trial, field: Field) -> tuple[Trial, list[Trial]]:
    """Return the trial of a cause that was taken out of a model, and those of the best of a field, compared fairly
    (:func:`~mjfriction.diagnose.search.short_list.fairly`).
    """
    again, *rivals = fairly(without, [own, *contenders(without, field, own.chosen.site.joint)])
    return again, rivals


def exchanged(
    model: Model, field: Field, chances: Chances, least: float, made: Collection[Kinds] = ()
) -> Exchange | None:
    """Return the exchange of one of a model's causes for another that beats it in its place by more than ``least``
    merit.

    Return None where there is none, or only such as were ``made`` before. ``chances`` gives the number of candidates
    among which the false-alarm level is divided.

    The first cause was chosen with nothing beside it: a payload at the flange may have stood in for a heavier first
    link and the rotor of the second joint together.
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
    # Whether a candidate contains the cause: it takes the cause's place elsewhere, as its richer form, where that pays.
    return cause.name in entrant.cause.contains
