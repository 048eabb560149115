"""Causes that turn out to be plainer than they were chosen as, once all others and the stated values are settled."""

from __future__ import annotations

from mjfriction.diagnose.fit.as_little import leaves_as_little
from mjfriction.diagnose.fit.model import Chosen, Model, build_model
from mjfriction.diagnose.fit.small_errors import USUAL, least_to_stand_out, removed, stands_out
from mjfriction.diagnose.search.field import Field

PART = 0.1  # of the mean square that a plainer cause removes: what a richer one adds to that is a small part of it


def as_plain(model: Model, asked: Field) -> Model:
    """Return the model with causes replaced by plainer ones that they contain, where these leave as little everywhere,
    or so little more that it does not stand out of the many small errors of a model, or, where there are any, is no
    larger than a usual one and a small part of what the plainer cause removes.

    A cause that contains another always fits at least as well: a spring that bends is chosen for what a refitted link
    takes later, or for the pull of a cable beside an offset, and an offset remains.
    """
    for choice in model.chosen:
        rest = tuple(one for one in model.chosen if one.key != choice.key)
        for plain in _plainer(choice, asked):
            if plain.key in [one.key for one in rest]:
                continue
            there = build_model(model.gap, model.nuisance, (*rest, plain))
            if there.admissible() is there and _leaves_hardly_more(there, model, choice, plain):
                model = there
                break
    return model


def _leaves_hardly_more(there: Model, model: Model, choice: Chosen, plain: Chosen) -> bool:
    # Whether a model with a ``plain`` cause in place of a ``choice`` of another one leaves hardly more than that does.
    gap, own, without = model.gap, choice.site.joint, there.without(plain)
    neither, plainer, richer = (one.heldout_residual() for one in (without, there, model))
    usual = {joint: (USUAL * gap.rms(gap.measured[:, joint], joint)) ** 2 for joint in gap.examined}
    amid_others = least_to_stand_out(gap, own, richer[:, own]) > 0.0
    slight = amid_others and removed(gap, own, plainer, richer) < PART * removed(gap, own, neither, plainer)
    return all(
        leaves_as_little(there, model, [joint])
        or not stands_out(gap, joint, plainer, richer)
        or (slight and removed(gap, joint, plainer, richer) < usual[joint])
        for joint in gap.examined
    )


def _plainer(choice: Chosen, asked: Field) -> list[Chosen]:
    # The causes of the field that a choice contains, and then the form that it is the richer form of.
    here = [entrant for entrant in asked if entrant.joint == choice.site.joint]
    contained = [entrant for entrant in here if entrant.cause.name in choice.cause.contains]
    straight = [entrant for entrant in here if choice.cause.contains and entrant.cause.richer is type(choice.cause)]
    return [Chosen(entrant.cause, entrant.sites[0]) for entrant in (*contained, *straight)]
