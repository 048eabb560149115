"""Companions that found causes ask for: each is one question posed in advance, not the best of many candidates."""

from __future__ import annotations

import numpy as np
from scipy.stats import t as student

from mjfriction.diagnose.causes.varying import Warming, WarmUpDrift
from mjfriction.diagnose.fit.model import Chosen, Model
from mjfriction.diagnose.fit.trial import try_out
from mjfriction.diagnose.search.field import Field, present

FULLER_CHANCE = 0.05  # chance level for one more strength of a cause: its 95 % interval then excludes zero
# The offset of the EMPS log comes out at 0.008 and at 0.03. On robots whose values are all a little off, other halves
# that are not real came out at 0.010 and 0.026.
KIN_CHANCE = 0.01  # chance level at which a cause's other half is added
LEAST_KIN = 0.02  # of its partner's effort: least effort of a cause's other half
LEAST_KIN_EFFECT = 0.002  # of the joint's effort: least effort of a cause's other half
# Of the mean square that running time takes off: share that the logged temperature must take off too.
NEARLY_AS_MUCH = 0.95


def fulfilled(model: Model) -> Model:
    """Return the model with causes in their fuller form, which has one more strength, where that strength is beyond
    chance and lowers the held-out error; of several forms, in the one that lowers it most.
    """
    for choice in model.chosen:
        if not choice.cause.fuller:
            continue
        blocks, without = model.gap.blocks, model.without(choice)
        least = float(np.sum(without.with_candidate(choice).heldout_errors(blocks.folds)))
        for form in choice.cause.fuller:
            whole = Chosen(form(), choice.site)
            full = without.with_candidate(whole)
            strengths = full.fitted
            deviation = float(np.sqrt(full.covariance(blocks.group)[-1, -1]))
            sure = abs(strengths[-1]) > student.ppf(1.0 - 0.5 * FULLER_CHANCE, blocks.groups - 1) * deviation
            error = float(np.sum(full.heldout_errors(blocks.folds)))
            count = len(whole.cause.quantities(model.gap, whole.site))
            if sure and error < least and whole.cause.admissible(model.gap, whole.site, strengths[-count:]):
                model, least = without.with_also(whole), error
    return model


def plainer(model: Model, field: Field) -> Model:
    """Return the model with causes replaced by simpler ones that they contain, where the extra strength gains nothing.

    A spring may be chosen before the waves on its joint are, and turn out to be a mere offset beside them.
    """
    for choice in model.chosen:
        without = model.without(choice)
        own = try_out(without, choice)
        for entrant in field:
            if own is None or entrant.joint != choice.site.joint or entrant.cause.name not in choice.cause.contains:
                continue
            plain = try_out(without, Chosen(entrant.cause, entrant.sites[0]))
            if plain is not None and plain.merit > own.merit and not present(model, entrant):
                model = without.with_also(plain.chosen)
    return model


def by_temperature(model: Model, field: Field) -> Model:
    """Return the model with friction that follows the logged temperature in the place of friction that settles with
    running time, where it takes off nearly as much error.

    A temperature sensor that reads whole degrees fits a little worse, which does not make running time the cause.
    """
    warming = {entrant.joint: entrant for entrant in field if isinstance(entrant.cause, Warming)}
    for choice in model.chosen:
        joint = choice.site.joint
        if not isinstance(choice.cause, WarmUpDrift) or joint not in warming:
            continue
        without = model.without(choice)
        trial = try_out(without, Chosen(warming[joint].cause, warming[joint].sites[0]))
        if trial is None:
            continue
        warmed = without.with_also(trial.chosen)
        none, own, other = (
            model.gap.rms(one.heldout_residual()[:, joint], joint) ** 2 for one in (without, model, warmed)
        )
        if none - other > NEARLY_AS_MUCH * (none - own):
            model = warmed
    return model


def with_kin(model: Model, field: Field) -> Model:
    """Return the model with the other halves of its causes, where these are beyond chance.

    A found cause names its other half, if it has one. That is one question posed in advance, not the best of many
    candidates, so it is tested at the plain level. Its size is measured against its partner, apart from a small least
    share of the joint's effort.
    """
    for choice in model.chosen:
        for entrant in field:
            if entrant.cause.name not in choice.cause.kin or entrant.joint != choice.site.joint:
                continue
            if present(model, entrant):
                continue
            other = Chosen(entrant.cause, entrant.sites[0])
            trial = try_out(model, other, repeating=True)
            own = try_out(model.without(choice), choice)
            if not trial or not own or trial.chance > KIN_CHANCE:
                continue
            if trial.effect > max(LEAST_KIN * own.effect, LEAST_KIN_EFFECT):
                model = model.with_also(other)
    return model
