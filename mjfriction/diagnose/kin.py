"""What a cause that was found asks for besides: one question put beforehand, not the best of many."""

from __future__ import annotations

import numpy as np
from scipy.stats import t as student

from mjfriction.diagnose.causes.varying import Warming, WarmUpDrift
from mjfriction.diagnose.field import Field, present
from mjfriction.diagnose.model import Chosen, Model
from mjfriction.diagnose.trial import try_out

FULLER_CHANCE = 0.05  # at which one strength more of a cause is taken along: that of its 95 % interval leaving out zero
# The EMPS log's offset stands at 0.008 and at 0.03; on robots of which all is a little off, halves that are none stood
# at 0.010 and 0.026.
KIN_CHANCE = 0.01  # at which a cause's other half is taken along
LEAST_KIN = 0.02  # of its partner's effort that a cause's other half must reach
LEAST_KIN_EFFECT = 0.002  # and of the joint's effort
NEARLY_AS_MUCH = 0.95  # of the mean square that running time takes off, that the logged temperature takes off too


def fulfilled(model: Model) -> Model:
    """Return the model with those of its causes that may have one strength more in that form, where it tells."""
    for choice in model.chosen:
        if choice.cause.fuller is None:
            continue
        blocks, without = model.gap.blocks, model.without(choice)
        whole = Chosen(choice.cause.fuller(), choice.site)
        plain, full = without.with_candidate(choice), without.with_candidate(whole)
        strengths = full.fitted
        deviation = float(np.sqrt(full.covariance(blocks.group)[-1, -1]))
        sure = abs(strengths[-1]) > student.ppf(1.0 - 0.5 * FULLER_CHANCE, blocks.groups - 1) * deviation
        errors = [float(np.sum(normal.heldout_errors(blocks.folds))) for normal in (plain, full)]
        count = len(whole.cause.quantities(model.gap, whole.site))
        if sure and errors[1] < errors[0] and whole.cause.admissible(model.gap, whole.site, strengths[-count:]):
            model = without.with_also(whole)
    return model


def plainer(model: Model, field: Field) -> Model:
    """Return the model with what causes are but for one strength in their places, where the strength gains nothing.

    A spring may be told before the waves on its joint are, and be a mere offset beside them.
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
    """Return the model with friction that follows the logged temperature in the place of what settles with running
    time, where that takes nearly as much off: a sensor that reads whole degrees does not make it time that counts.
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
    """Return the model with the other halves of its causes, where they tell.

    A found cause names its other half, if it has one.  That is one question asked beforehand, not the best of many
    answers, so that it stands at the plain level; and it is measured against its partner, not against the effort.
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
