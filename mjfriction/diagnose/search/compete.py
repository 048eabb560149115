"""Stepwise selection of causes: forward by what they explain on held-out motion, then backward."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from mjfriction.diagnose.fit.model import Chosen, Model, build_model, cause_block, same_columns
from mjfriction.diagnose.fit.nuisance import Nuisance
from mjfriction.diagnose.fit.shapes import reshaped
from mjfriction.diagnose.fit.tangent import straightened
from mjfriction.diagnose.fit.trial import Trial, try_out
from mjfriction.diagnose.search.as_known import as_known
from mjfriction.diagnose.search.courses import as_courses
from mjfriction.diagnose.search.exchange import Kinds, exchanged
from mjfriction.diagnose.search.field import Chances, Field, chances_in
from mjfriction.diagnose.search.kin import by_temperature, fulfilled, plainer, with_kin
from mjfriction.diagnose.search.one_gear import geared
from mjfriction.diagnose.search.one_transmission import leaning
from mjfriction.diagnose.search.oscillations import new_oscillations
from mjfriction.diagnose.search.refusal import proved, refused
from mjfriction.diagnose.search.richer import PAYS, curves_apart, enriched, in_richer_form
from mjfriction.diagnose.search.short_list import SHORT_LIST, Tried, all_tried, best_bent, fairly, passing, ranked
from mjfriction.identify.gap import Gap
from mjfriction.progress import Tell, silently

MOST_CAUSES = 12
MOST_STEPS = 40  # candidates chosen or found wanting in all of a search; one that ends well takes fewer
# A chosen cause stays up to this many times the chance level at which it may be chosen: what is as good stays.
KEPT = 10
# Merit difference that does not count: the data are then only 1.6 times as likely under one cause as the other.
NO_DIFFERENCE = 1.0
# Share of a diagnosis that is search; share of the remaining search that is left after each cause found.
SEARCHED, FURTHER = 0.8, 0.7


def never(_: Model) -> bool:
    """Return False: no model ends the search early."""
    return False


def compete(
    gap: Gap,
    nuisance: Nuisance,
    field: Field,
    tell: Tell = silently,
    *,
    begin: tuple[Chosen, ...] = (),
    enough: Callable[[Model], bool] = never,
) -> tuple[Model, Field]:
    """Choose the causes that the log shows, strongest first; return the model and the field without what was refused.

    Forward: a candidate must have strengths beyond chance (Wald's test with block-clustered covariance, at a level
    divided by the number of candidates) and take away a share of the held-out error. The one that takes most is chosen,
    until none is left. Backward: causes that later ones have made needless are dropped. Proof: where a steady tone or a
    swinging load is detected, all candidates compete anew beside it; causes that
    :func:`~mjfriction.diagnose.search.refusal.refused` names are refused, and the others compete anew without them.
    Where nothing competes, no oscillations are searched for. Last, richer forms and curves along the stroke replace
    causes that only begin to describe them, and causes that these make needless are dropped.

    A search is broken off when it has come to more causes than can be true, and its result is hardly credible. It is
    repeated at most once, beside the oscillations that were detected, and causes that are refused are dropped. The same
    holds for one that goes round and round, which is not repeated at all.

    ``begin`` holds causes that were found already and start the search. As soon as a model is ``enough``, it is
    returned as it is.
    """
    if not field:
        return build_model(gap, nuisance, ()), field
    asked, chances, heard, steps = field, chances_in(field), False, 0
    while True:
        model, made = _forward(_with_found(gap, nuisance, begin), asked, chances, tell, enough)
        steps += made
        if enough(model):
            return model, asked
        hopeless = len(model.noteworthy) >= MOST_CAUSES
        model = as_known(plainer(pruned(model, chances), asked))
        if not hopeless:
            model, made = _exchanged(model, asked, chances, tell, enough, MOST_STEPS - steps)
            steps += made
        endless = steps >= MOST_STEPS
        hopeless = hopeless or endless
        sources = [] if endless or (hopeless and heard) else new_oscillations(model)
        if sources:
            nuisance, heard = nuisance.along(gap, (*nuisance.sources, *sources)), True
            continue
        no_causes = refused(model)
        asked, asked_before = _without_richer(_narrowed(asked, no_causes), no_causes), asked
        begin, began = tuple(choice for choice in begin if choice.key not in {one.key for one in no_causes}), begin
        # What is refused may be a form that does not compete, such as a richer one: the search would find it again.
        if hopeless or (asked == asked_before and begin == began):
            for choice in no_causes:
                model = model.without(choice)
            return _in_final_form(model, field, chances), asked


def _in_final_form(model: Model, field: Field, chances: Chances) -> Model:
    # Forms that do not compete replace those that did, where they do better; what they make needless is dropped.
    model = fulfilled(model)
    model = curves_apart(enriched(model, field))
    model = by_temperature(model, field)
    model = as_courses(model)
    model = geared(model)
    model = pruned(model, chances)
    model = with_kin(model, field)
    return straightened(model)


def _with_found(gap: Gap, nuisance: Nuisance, begin: tuple[Chosen, ...]) -> Model:
    model = build_model(gap, nuisance, tuple(replace(choice, tangent=None) for choice in begin))
    return as_known(straightened(reshaped(model))) if begin else model


def _narrowed(field: Field, no_causes: list[Chosen]) -> Field:
    # The field without refused causes: neither these nor any later ones of their kind at the joint are tried again.
    out = []
    for entrant in field:
        orders = [one.site.order for one in no_causes if (type(one.cause), one.site.joint) == entrant.kind]
        if min(orders, default=entrant.times) > 0:
            out.append(replace(entrant, times=min([*orders, entrant.times])))
    return tuple(out)


def _without_richer(field: Field, no_causes: list[Chosen]) -> Field:
    # The field without richer forms of refused causes: they would stand in for what refused the simpler ones.
    plain = {(type(one.cause), one.site.joint) for one in no_causes}
    return tuple(entrant for entrant in field if (entrant.cause.simpler, entrant.joint) not in plain)


def _forward(
    model: Model, field: Field, chances: Chances, tell: Tell, enough: Callable[[Model], bool]
) -> tuple[Model, int]:
    # The model with all candidates that are proved, and the number of steps that this took. Candidates that show only
    # while joints rest are set aside, and tried again when no other is left: every contact yields a little at a
    # reversal, at every joint.
    asked, anew, steps = field, True, 0
    tried = Tried({}, {})
    while (named := len(model.noteworthy)) < MOST_CAUSES and not enough(model):
        tell(f"searching for causes, {named} so far", SEARCHED * (1.0 - FURTHER ** (1 + named)))
        more, left = _one_more(model, asked, chances, tried)
        steps += 1
        if more is not None:
            felt = cause_block(more.gap, more.chosen[-1])[0].keys()
            more = fulfilled(more)
            more = reshaped(more, felt | cause_block(more.gap, more.chosen[-1])[0].keys())
            more = leaning(as_known(straightened(more)), chances)
            model, asked, anew, tried = more, left, len(left) == len(field), Tried({}, {})
        elif anew:
            break
        else:
            asked, anew = field, True
    return model, steps


def _one_more(model: Model, field: Field, chances: Chances, tried: Tried) -> tuple[Model | None, Field]:
    # The model with the best candidate of the field that is proved, if there is one, and the field without those that
    # were not proved. What was ``tried`` beside the model before is not tried again.
    while able := _passing(model, field, chances, tried):
        trials = fairly(model, able)
        while trials:
            best = _best(model, field, trials)
            more = model.with_also(best.chosen)
            if proved(more, best.chosen):
                return _richer(model, best) or more, field
            trials.remove(best)
            field = _narrowed(field, [best.chosen])
    return None, field


def _exchanged(
    model: Model, field: Field, chances: Chances, tell: Tell, enough: Callable[[Model], bool], most: int
) -> tuple[Model, int]:
    # After each exchange of one cause for another, the remaining error is searched again, until that has taken ``most``
    # steps or more. This may lead back to an earlier model, so no pair of kinds is exchanged twice.
    made, steps = set[Kinds](), 0
    while steps < most:
        exchange = exchanged(model, field, chances, NO_DIFFERENCE, made)
        if exchange is None:
            break
        made.add(exchange.kinds)
        model, more = _forward(as_known(straightened(reshaped(exchange.model))), field, chances, tell, enough)
        model = as_known(plainer(pruned(model, chances), field))
        steps += more
    return model, steps


def _richer(model: Model, trial: Trial) -> Model | None:
    # The model with a cause at the same joint in its richer form, where that gains as much as adding the new cause:
    # either the cause that is in the model, or the newcomer in its place.
    new = trial.chosen
    for choice in model.chosen:
        if choice.site.joint != new.site.joint or choice.tangent or choice.cause.whole_arm:
            continue
        for plain in (choice, new):
            richer = None if plain.cause.richer is None else in_richer_form(model, choice, plain)
            if richer is not None and richer.gain > trial.merit - NO_DIFFERENCE:
                return richer.model
    return None


def _best(model: Model, field: Field, trials: list[Trial]) -> Trial:
    # The trial of largest merit, or of a simpler form of that cause where the richer one does not pay. Among trials
    # whose merit differs too little to count, or whose columns are the same under another name (e.g. a link that only
    # turns about its own vertical joint, and the rotor), the first in the field.
    causes = [type(entrant.cause) for entrant in field]
    best = max(trials, key=lambda trial: trial.merit)
    simpler = [
        trial
        for trial in trials
        if (type(trial.chosen.cause), trial.chosen.site.joint) == (best.chosen.cause.simpler, best.chosen.site.joint)
        and trial.merit > best.merit - PAYS
    ]
    best = max(simpler, key=lambda trial: trial.merit, default=best)
    return min(
        (
            trial
            for trial in trials
            if abs(trial.merit - best.merit) < NO_DIFFERENCE or same_columns(model.gap, trial.chosen, best.chosen)
        ),
        key=lambda trial: causes.index(type(trial.chosen.cause)),
    )


def _passing(model: Model, field: Field, chances: Chances, before: Tried) -> list[Trial]:
    # The passing trials of the first short list that has any. Where none passes, the next list is tried: an effect that
    # no cause fits at one joint may rank a dozen candidates there before an obvious one at another joint.
    choices, tried = ranked(model, field), list[Trial]()
    for first in range(0, len(choices), SHORT_LIST):
        own = all_tried(model, choices[first : first + SHORT_LIST], before)
        own = best_bent(model, own + all_tried(model, _alike(own, choices[first + SHORT_LIST :]), before), chances)
        tried += own
        best = [trial for trial in passing(own, chances) if not _stands_for_less(model, trial, tried, chances)]
        if best:
            return best
    return []


def _alike(tried: list[Trial], others: list[Chosen]) -> list[Chosen]:
    # Of the other candidates, those of the best trial's kind where that kind is ranked by what its own joint feels: at
    # another joint, where the joints before it feel more, it may do more.
    best = max(tried, key=lambda trial: trial.merit, default=None)
    if best is None or not best.chosen.cause.ranked_alone:
        return []
    return [choice for choice in others if type(choice.cause) is type(best.chosen.cause)]


def _stands_for_less(model: Model, trial: Trial, tried: list[Trial], chances: Chances) -> bool:
    # Whether another cause does more at the joint and leaves nothing for this one, though it is itself too small to
    # pass: it is beyond chance, but too small a part of the joint's friction.
    for other in tried:
        same = other.chosen.cause.name == trial.chosen.cause.name
        if same or other.chosen.site.joint != trial.chosen.site.joint or other.merit <= trial.merit:
            continue
        number = chances.among(other.chosen.cause)
        if other.passes(number) or not other.beyond_chance(number):
            continue
        beside = model.with_also(other.chosen)
        again = try_out(beside, trial.chosen)
        if again is None or not again.passes(chances.among(trial.chosen.cause)):
            return True
    return False


def pruned(model: Model, chances: Chances) -> Model:
    """Return the model without the causes that the others make needless, the least of them first."""
    while model.chosen:
        trials = [(choice, try_out(model.without(choice), choice)) for choice in model.chosen]
        # Inadmissible causes go first, and of several the one that takes least off: it makes the others at its joint
        # impossible.
        needless = [
            (trial is not None, trial.gain if trial else _taken_off(model, choice), choice)
            for choice, trial in trials
            if not _stays(trial, chances)
        ]
        if not needless:
            return model
        *_, least = min(needless, key=lambda entry: entry[:2])
        model = reshaped(model.without(least), cause_block(model.gap, least)[0].keys())
    return model


def _taken_off(model: Model, choice: Chosen) -> float:
    return float(np.sum(model.without(choice).heldout_errors) - np.sum(model.heldout_errors))


def _stays(trial: Trial | None, chances: Chances) -> bool:
    return trial is not None and trial.passes(chances.among(trial.chosen.cause) / KEPT)
