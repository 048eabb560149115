"""Presliding within the travel that any contact yields: when it is a finding all the same."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from mjfriction.diagnose.causes.presliding import Bristle, Presliding
from mjfriction.diagnose.causes.stribeck import Stribeck
from mjfriction.diagnose.fit.model import Chosen, Key, Model
from mjfriction.diagnose.fit.refitted import FEWEST_JOINTS
from mjfriction.diagnose.fit.small_errors import noise_alone
from mjfriction.record.log import Floats
from mjfriction.robot.friction import stated_levels

# Such presliding is more than a contact's where it takes away more than this many times the mean square left at its
# joint.
NO_CONTACT = 3.0
# Another joint is rigid if the share of its level that builds up is below this fraction of this joint's share.
RIGID = 0.3
DEVIATIONS = 2.0  # standard deviations by which it must be below
FEWEST_RIGID = 2  # other joints that must be rigid, or all where fewer can tell


def more_than_contacts(model: Model, before: Mapping[Key, Floats], after: Floats) -> set[Key]:
    """Return the causes that are presliding within the travel that any contact yields, but findings all the same.

    They are findings only on a machine that does not yield so throughout: where presliding is by far the largest error
    at its joint, or where other joints would show as short a travel and do not. A contact that sticks also yields, so
    beside a Stribeck curve the other joints are no measure. Nor is it a finding on a machine whose other small errors
    show, of which it is one. Of a joint alone, nothing says that it yields no more than any, and it is a finding.

    ``before`` and ``after`` (rows, joints) are held-out residuals, without each cause and with all.
    """
    gap = model.gap
    short = [
        (choice, choice.cause)
        for choice, fitted in model.fitted_causes
        if isinstance(choice.cause, Bristle) and not choice.cause.noteworthy(gap, choice.site, fitted)
    ]
    if len(short) >= FEWEST_JOINTS:
        return set()
    if len(gap.examined) == 1:
        return {choice.key for choice, _ in short}
    if not noise_alone(gap, after):
        return set()

    def gained(choice: Chosen) -> float:
        joint = choice.site.joint
        without, own = (gap.rms(left[:, joint], joint) ** 2 for left in (before[choice.key], after))
        return without / own - 1.0

    sticking = {choice.site.joint for choice in model.chosen if choice.cause.name == Stribeck.name}
    return {
        choice.key
        for choice, bristle in short
        if gained(choice) > NO_CONTACT
        or (choice.site.joint not in sticking and _others_are_rigid(model, choice, bristle))
    }


def _others_are_rigid(model: Model, choice: Chosen, bristle: Bristle) -> bool:
    # Whether enough other joints would show a like share of their level that builds up over a like part of their
    # stroke, and do not.
    gap, joint = model.gap, choice.site.joint
    stroke = np.ptp(gap.motion.position, axis=0)
    strengths = model.strengths_of(choice)
    own_travel = bristle.travel(choice.site, strengths)
    part = bristle.taken_level(strengths) / max(_level(model, joint), 1e-300)
    yielding = {own.site.joint for own in model.chosen if isinstance(own.cause, Bristle)}
    tell = rigid = 0
    for other in gap.examined:
        travel = own_travel * float(stroke[other] / stroke[joint])
        alike = Chosen(Presliding(), replace(choice.site, joint=other, shape=(travel,)))
        ((least, most),) = alike.cause.shape_bounds(gap, alike.site)
        if other == joint or _level(model, other) <= 0.0 or not least < travel < most:
            continue
        tell += 1
        if other not in yielding:
            normal = model.with_candidate(alike)
            deviation = float(np.sqrt(normal.covariance(gap.blocks.group)[-1, -1]))
            rigid += normal.fitted[-1] + DEVIATIONS * deviation < RIGID * part * _level(model, other)
    return rigid > 0 and rigid >= min(FEWEST_RIGID, tell)


def _level(model: Model, joint: int) -> float:
    return stated_levels(model.gap.robot.table.joint[joint])[0]
