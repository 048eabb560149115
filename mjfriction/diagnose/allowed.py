"""Causes that what is settled after them leaves in a form which nature does not allow: in one which it does."""

from __future__ import annotations

from dataclasses import replace

from mjfriction.diagnose.field import Field
from mjfriction.diagnose.model import Chosen, Model
from mjfriction.diagnose.shapes import best_shape
from mjfriction.diagnose.trial import try_out


def as_allowed(model: Model, asked: Field) -> Model:
    """Return the model with causes that came out as nature does not allow in the best form that it does: another of
    their kind, or their own in another shape; without those that have none, for they explain nothing.
    """
    for choice in model.chosen:
        if _is_allowed(model, choice):
            continue
        without = model.without(choice)
        others = [best_shape(without, form) for form in _other_forms(choice, asked)]
        # A search that begins where nature allows nothing sees no way out; where another form is best, it does.
        own = [best_shape(without, replace(form, cause=choice.cause)) for form in others]
        trials = [trial for form in (*others, *own) if (trial := try_out(without, form)) is not None]
        model = without
        for trial in sorted(trials, key=lambda one: one.merit, reverse=True):
            other = without.with_also(trial.chosen)
            if _is_allowed(other, trial.chosen):
                model = other
                break
    return model.admissible()


def _is_allowed(model: Model, choice: Chosen) -> bool:
    strengths = [
        model.strengths[place] for one, place in zip(model.chosen, model.places, strict=True) if one.key == choice.key
    ]
    return all(choice.cause.admissible(model.gap, choice.site, own) for own in strengths)


def _other_forms(choice: Chosen, asked: Field) -> list[Chosen]:
    # What competes under the same name with the same shapes.
    return [
        Chosen(entrant.cause, choice.site)
        for entrant in asked
        if (entrant.joint, entrant.cause.name) == (choice.site.joint, choice.cause.name)
        and entrant.cause.shape_parameters == choice.cause.shape_parameters
    ]
