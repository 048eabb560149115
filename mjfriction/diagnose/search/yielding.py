"""Contacts that yield before they slide, at every joint of a machine: in the model from the start, and no finding."""

from __future__ import annotations

import numpy as np

from mjfriction.diagnose.causes.cause import Shape
from mjfriction.diagnose.causes.presliding import Presliding
from mjfriction.diagnose.fit.model import Chosen, Model, build_model
from mjfriction.diagnose.fit.nuisance import Nuisance
from mjfriction.diagnose.fit.refitted import FEWEST_JOINTS
from mjfriction.diagnose.fit.trial import try_out
from mjfriction.diagnose.search.field import Entrant, Field, size
from mjfriction.diagnose.search.refusal import proved
from mjfriction.diagnose.search.short_list import all_tried, ranked
from mjfriction.identify.gap import Gap


def yielding(gap: Gap, nuisance: Nuisance, field: Field) -> tuple[Chosen, ...]:
    """Return friction that builds up within the travel that every contact yields, at the joints that show it, if at
    least three do; otherwise nothing.

    If only one or two joints show it, it is looked for like any other cause.  If all joints have it, it shows at every
    reversal of a log that is good enough, and stands out more than anything else.  If it were found joint by joint,
    it would until then be mistaken for other causes that act at reversals.
    """
    model = build_model(gap, nuisance, ())
    own = tuple(entrant for entrant in field if isinstance(entrant.cause, Presliding))
    short = [choice for choice in ranked(model, own) if not _noteworthy(gap, choice)]
    if len(short) < FEWEST_JOINTS:
        return ()
    count = size(field)
    found = [trial.chosen for trial in all_tried(model, short) if trial.passes(count)]
    found = [choice for choice in found if not _noteworthy(gap, choice)]
    if len(found) < FEWEST_JOINTS:
        return ()
    there = {choice.site.joint: choice.site.shape for choice in found}
    shapes = sorted(set(there.values()))
    for other in own:
        found += _as_others_do(model, other, shapes, count) if other.joint not in there else []
    beside = build_model(gap, nuisance, tuple(found))
    out = tuple(choice for choice in found if proved(beside, choice))
    return out if len(out) >= FEWEST_JOINTS else ()


def _as_others_do(model: Model, entrant: Entrant, shapes: list[Shape], count: int) -> list[Chosen]:
    # Something else that is wrong with a joint may spoil its best-fitting travel; those of other joints are then tried.
    choices = [Chosen(entrant.cause, entrant.sites[0].shaped(shape)) for shape in shapes]
    trials = [try_out(model, choice) for choice in choices if not _noteworthy(model.gap, choice)]
    passing = [trial for trial in trials if trial is not None and trial.passes(count)]
    return [max(passing, key=lambda trial: trial.merit).chosen] if passing else []


def _noteworthy(gap: Gap, choice: Chosen) -> bool:
    return choice.cause.noteworthy(gap, choice.site, np.ones(1))
