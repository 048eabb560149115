"""Causes of a model that are no findings: they are refitted along, and listed as that."""

from __future__ import annotations

from mjfriction.diagnose.causes.catalog import STATED_LEVELS
from mjfriction.diagnose.model import Chosen, Key, Model, build_model
from mjfriction.diagnose.stated import Settled
from mjfriction.diagnose.trial import LEAST_EFFECT, effect
from mjfriction.identify.structure import Structure

LEAST_SEEN = 0.15  # of the mean square that is left at a joint, that a cause must take away there: 0.4 of the noise
DROWNED = 0.5  # of the mean square that is left unexplained at a joint, if any, that it must take away


def find_untold(settled: Settled, remaining: tuple[Structure, ...]) -> frozenset[Key]:
    """Return which causes of a settled model are no findings.

    What is next to nothing of the effort, or hardly shows beside what is left on motion not fitted, may be what the
    larger causes leave by a percent of misfit.  And a course that no cause is, ``remaining``, can be told in part by
    many: a hum looks a little like a late effort, a load that swings like a spring.  The other half of a cause, which
    was asked for by name, is told all the same.
    """
    model = settled.model
    left = {model.gap.robot.joints.index(entry.joint): entry.share for entry in remaining}
    out = {
        choice.key
        for choice, place in zip(model.chosen, model.places, strict=True)
        if not choice.cause.noteworthy(model.gap, choice.site, model.strengths[place])
        or (not _asked_for(model, choice) and effect(model.gap, choice, model.strengths[place]) < LEAST_EFFECT)
    }
    for choice in (*model.chosen, *settled.levels):
        if choice.key not in out and not _asked_for(model, choice) and not _shows(model, choice, left):
            out.add(choice.key)
    return frozenset(out)


def _asked_for(model: Model, choice: Chosen) -> bool:
    return any(choice.cause.name in other.cause.kin and other.site.joint == choice.site.joint for other in model.chosen)


def _shows(model: Model, choice: Chosen, left: dict[int, float]) -> bool:
    # Whether a cause takes enough off the mean square on motion not fitted at its joint; at any, for the whole arm.
    gap, joint = model.gap, choice.site.joint
    if choice.cause is STATED_LEVELS:
        without = build_model(gap, model.nuisance.without_level(joint), model.chosen)
    else:
        without = model.without(choice)
    before, after = without.heldout_residual(), model.heldout_residual()
    for where in gap.examined if choice.cause.whole_arm else (joint,):
        own = gap.rms(after[:, where], where) ** 2
        taken = gap.rms(before[:, where], where) ** 2 - own
        if taken > max(LEAST_SEEN, DROWNED * left.get(where, 0.0)) * own:
            return True
    return False
