"""Replace causes that became physically inadmissible through later steps by an admissible form."""

from __future__ import annotations

from dataclasses import replace

from mjfriction.diagnose.fit.model import Chosen, Model
from mjfriction.diagnose.fit.shapes import best_shape
from mjfriction.diagnose.fit.trial import try_out
from mjfriction.diagnose.search.field import Field


def as_allowed(model: Model, asked: Field) -> Model:
    """Return the model with each inadmissible cause replaced by its best admissible form.

    The form is another cause of its kind, or the same cause with another shape. A cause without an admissible form is
    dropped, since it explains nothing.
    """
    for choice in model.chosen:
        if _is_allowed(model, choice):
            continue
        without = model.without(choice)
        others = [best_shape(without, form) for form in _other_forms(choice, asked)]
        # A shape search that starts where the cause is inadmissible finds no way out; one that starts at the best shape
        # of another form does.
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
    own = [fitted for one, fitted in model.fitted_causes if one.key == choice.key]
    return all(choice.cause.admissible(model.gap, choice.site, fitted) for fitted in own)


def _other_forms(choice: Chosen, asked: Field) -> list[Chosen]:
    # Causes of the field with the same name at the same joint and the same shape parameters.
    return [
        Chosen(entrant.cause, choice.site)
        for entrant in asked
        if (entrant.joint, entrant.cause.name) == (choice.site.joint, choice.cause.name)
        and entrant.cause.shape_parameters == choice.cause.shape_parameters
    ]
