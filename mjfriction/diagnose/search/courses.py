"""Replace waves, spots and springs that only approximate an edge or a curve along the stroke by that."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mjfriction.diagnose.causes.along_stroke import (
    AlongStroke,
    FrictionAlongStroke,
    RisingAlongStroke,
    TorqueAlongStroke,
    travelled,
)
from mjfriction.diagnose.causes.friction_edge import FrictionAbove, FrictionBelow
from mjfriction.diagnose.causes.spring import Spring
from mjfriction.diagnose.causes.waves import Cogging
from mjfriction.diagnose.fit.as_little import leaves_as_little
from mjfriction.diagnose.fit.exact import level_changes
from mjfriction.diagnose.fit.model import Chosen, Key, Model, build_model, without_contained
from mjfriction.diagnose.fit.trial import try_out
from mjfriction.diagnose.search.field import make_field
from mjfriction.diagnose.search.refusal import proved
from mjfriction.diagnose.search.richer import PAYS, paid_gain
from mjfriction.diagnose.search.short_list import contenders
from mjfriction.diagnose.search.stroke_curve import stroke_curves, vague_waves

ALONG = {Spring.name, Cogging.name}
# One smooth curve may leave this many times the RMS that the waves and springs leave whose place it takes, if that is
# less more than this fraction of the mean square that it removes: eight half waves follow hardly any curve exactly.
NEARLY, OF_REMOVED = 1.25, 0.02


def as_courses(model: Model) -> Model:
    """Return the model with edges and curves along the stroke in the place of causes that only approximate them.

    An edge of the friction level replaces waves and spots where it pays for itself. A friction curve replaces waves,
    spots or an edge where it pays for its extra strengths, or where the periods of several waves are not known and it
    leaves as little error. A torque curve replaces a spring with waves beside it where it pays, as where a hose pulls
    from one place on, and waves and springs that one smooth curve does as well as, where it leaves hardly more error.
    """
    vague = {joint for _, joint, _ in vague_waves(model)}
    for joint in model.gap.examined:
        own = _along(model, joint)
        if all(isinstance(choice.cause, FrictionAlongStroke) for choice in own):
            continue
        if not any(isinstance(choice.cause, FrictionAbove | FrictionBelow) for choice in own):
            there = _with_edge(model, joint)
            if there is not None and paid_gain(model, there.chosen) > PAYS:
                model, own = there, _along(there, joint)
        there = _with_course(model, joint, frozenset(choice.key for choice in own), FrictionAlongStroke())
        if there is not None and (
            paid_gain(model, there.chosen) > PAYS or (joint in vague and leaves_as_little(there, model, [joint]))
        ):
            model = there
    for joint in model.gap.examined:
        own = [choice for choice in model.chosen if choice.site.joint == joint and choice.cause.name in ALONG]
        if {choice.cause.name for choice in own} != ALONG:
            continue
        there = _with_torque(model, joint, frozenset(choice.key for choice in own))
        if there is not None and paid_gain(model, there.chosen) > PAYS:
            model = there
    for curve in stroke_curves(model, model.heldout_residual()):
        joint = model.gap.robot.joints.index(curve.structure.joint)
        there = _with_torque(model, joint, curve.keys)
        if there is not None and leaves_as_little(there, model, [joint]):
            model = there
        elif there is not None and _hardly_more(there, model, joint):
            *others, course = there.chosen
            replaced = tuple(choice for choice in model.chosen if choice.key in curve.keys)
            model = replace(there, chosen=(*others, replace(course, instead=replaced)))
    return model


def _hardly_more(there: Model, than: Model, joint: int) -> bool:
    gap = there.gap
    without = there.without(there.chosen[-1])
    left, least, bare = (gap.rms(one.heldout_residual()[:, joint], joint) for one in (there, than, without))
    return left < NEARLY * least and left**2 - least**2 < OF_REMOVED * (bare**2 - left**2)


def _along(model: Model, joint: int) -> list[Chosen]:
    name = FrictionAlongStroke.name
    return [choice for choice in model.chosen if (choice.cause.name, choice.site.joint) == (name, joint)]


def _with_edge(model: Model, joint: int) -> Model | None:
    # Where levels are refitted, friction may as well be higher above a place as lower below it: the edge is taken on
    # the side that leaves the level on the other nearer to what is stated.
    own = {choice.key for choice in _along(model, joint)}
    rest = tuple(choice for choice in model.chosen if choice.key not in own)
    without = build_model(model.gap, model.nuisance, rest)
    field = make_field(model.gap, (FrictionAbove(), FrictionBelow()))
    trials = contenders(without, tuple(entrant for entrant in field if entrant.joint == joint))
    tried = [without.with_also(trial.chosen) for trial in trials]
    found = [there for there in tried if proved(there, there.chosen[-1])]
    best = min(found, key=lambda there: float(np.sum(there.heldout_errors)), default=None)
    if best is None:
        return None
    as_good = (there for there in found if leaves_as_little(there, best, [joint]))
    return min(as_good, key=lambda there: level_changes(there).get(joint, 0.0))


def _with_torque(model: Model, joint: int, keys: frozenset[Key]) -> Model | None:
    # With the course that leaves less of what was held out: one that rises may do so wildly where motion hardly went.
    tried = [_with_course(model, joint, keys, course) for course in (TorqueAlongStroke(), RisingAlongStroke())]
    found = [there for there in tried if there is not None]
    return min(found, key=lambda there: float(np.sum(there.heldout_errors)), default=None)


def _with_course(model: Model, joint: int, keys: frozenset[Key], course: AlongStroke) -> Model | None:
    if not travelled(model.gap, joint):
        return None
    whole = Chosen(course, course.along(model.gap, joint))
    others = (choice for choice in model.chosen if choice.key not in keys | {whole.key})
    rest = without_contained(others, whole)
    without = build_model(model.gap, model.nuisance, rest)
    if try_out(without, whole) is None:
        return None
    there = without.with_also(whole)
    return there if proved(there, whole) else None
