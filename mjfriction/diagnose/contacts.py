"""Friction that builds up within the travel that any contact yields: where it is more than that."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from mjfriction.diagnose.causes.presliding import Presliding
from mjfriction.diagnose.causes.stribeck import Stribeck
from mjfriction.diagnose.model import Chosen, Key, Model
from mjfriction.diagnose.refitted import FEWEST_JOINTS
from mjfriction.record.log import Floats
from mjfriction.robot.friction import stated_levels

# Times the mean square left at a joint, that such friction takes away there, for it to be more than a contact's.
NO_CONTACT = 3.0
RIGID = 0.3  # of the part of its level that builds up at a joint, below which it has to be at others that are rigid
DEVIATIONS = 2.0  # by which it is below
FEWEST_RIGID = 2  # others, or all where a machine has fewer


def more_than_contacts(model: Model, before: Mapping[Key, Floats], after: Floats) -> set[Key]:
    """Return which causes are friction that builds up within the travel that any contact yields, and are findings all
    the same: of a machine that does not yield so throughout, where it is by far the most that is wrong with its joint,
    or where others would show as short a travel and do not.  A contact that sticks yields besides: beside a Stribeck
    curve others are no measure.

    ``before`` and ``after`` (rows, joints) are left on motion not fitted, without each cause and with all.
    """
    gap = model.gap
    short = [
        choice
        for choice, place in zip(model.chosen, model.places, strict=True)
        if choice.cause.name == Presliding.name
        and not choice.cause.noteworthy(gap, choice.site, model.strengths[place])
    ]
    if len(short) >= FEWEST_JOINTS:
        return set()

    def gained(choice: Chosen) -> float:
        joint = choice.site.joint
        without, own = (gap.rms(left[:, joint], joint) ** 2 for left in (before[choice.key], after))
        return without / own - 1.0

    sticking = {choice.site.joint for choice in model.chosen if choice.cause.name == Stribeck.name}
    return {
        choice.key
        for choice in short
        if gained(choice) > NO_CONTACT or (choice.site.joint not in sticking and _others_are_rigid(model, choice))
    }


def _others_are_rigid(model: Model, choice: Chosen) -> bool:
    # Whether the others would show that as much of their levels builds up over as large a part of their strokes.
    gap, joint = model.gap, choice.site.joint
    stroke = np.ptp(gap.motion.position, axis=0)
    place = model.places[[own.key for own in model.chosen].index(choice.key)]
    part = choice.cause.taken_level(model.strengths[place]) / max(_level(model, joint), 1e-300)
    yielding = {own.site.joint for own in model.chosen if own.cause.name == Presliding.name}
    others = [other for other in gap.examined if other != joint and _level(model, other) > 0.0]
    rigid = 0
    for other in others:
        travel = choice.site.shape[0] * float(stroke[other] / stroke[joint])
        alike = Chosen(Presliding(), replace(choice.site, joint=other, shape=(travel,)))
        ((least, most),) = alike.cause.shape_bounds(gap, alike.site)
        if other not in yielding and least < travel < most:
            normal = model.with_candidate(alike)
            deviation = float(np.sqrt(normal.covariance(gap.blocks.group)[-1, -1]))
            rigid += normal.fitted[-1] + DEVIATIONS * deviation < RIGID * part * _level(model, other)
    return bool(others) and rigid >= min(FEWEST_RIGID, len(others))


def _level(model: Model, joint: int) -> float:
    return stated_levels(model.gap.robot.table.joint[joint])[0]
