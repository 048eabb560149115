"""Robots that are stated exactly: what their links seem to be off by is then a cause."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from scipy.stats import t as student

from mjfriction.diagnose.causes.catalog import STATED_LEVELS
from mjfriction.diagnose.causes.cause import Site
from mjfriction.diagnose.causes.links import LinkScale, LoneLink, LoneWholeLink
from mjfriction.diagnose.causes.torque_constant import TorqueConstant
from mjfriction.diagnose.field import Field, chances_in
from mjfriction.diagnose.model import Chosen, Model, build_model, without_contained
from mjfriction.diagnose.nuisance import Nuisance, make_nuisance
from mjfriction.diagnose.short_list import contenders, fairly, passing
from mjfriction.diagnose.tangent import straightened
from mjfriction.diagnose.trial import FEWEST_JOINTS
from mjfriction.identify.gap import Gap
from mjfriction.record.log import Floats
from mjfriction.robot.friction import stated_levels

MOST_JOINTS = 0.75  # share of joints whose changes are typical
EXACT = 0.01  # of the stated friction: typical change of the other joints up to which a robot, links and all, is right
FEWEST_OTHERS = 2  # joints, that can say how far friction usually is off
UNKNOWN = 0.04  # of the stated friction, that is taken for it where they lack
NEARLY_ALL = 0.99  # of the mean square that refitted links take off any joint's error, that one cause may take instead
AS_GOOD = 1.02  # of what refitted links leave at any joint, that one cause may leave in their place


def typical(changes: Sequence[float], *, at_least: bool = False) -> float:
    """Return the change that most joints stay below; ``at_least`` the largest that joints have and that most reach."""
    return float(np.quantile(changes, MOST_JOINTS, method="lower" if at_least else "linear"))


def usually_off(changes: Mapping[int, float], joint: int, *, at_least: bool = False) -> float:
    """Return by how much the friction of joints beside one is off as a rule; a few percent where too few can say.

    ``at_least``: of two or three others one that is far off says nothing of the rest.
    """
    others = [value for other, value in changes.items() if other != joint]
    return typical(others, at_least=at_least) if len(others) >= FEWEST_OTHERS else UNKNOWN


def stated_exactly(model: Model) -> bool:
    """Return whether friction is as stated at nearly all joints, so that the rest may be believed to be so too.

    What a cause leaves of its joint's friction is a matter of its form: where enough others can say, they do.  And
    before any is found, what makes a fit uncertain may be causes, and is no reason to believe in what is stated.
    """
    changes, others = least_off(model) if model.chosen else level_changes(model), _untouched(model)
    asked = others if len(others) >= FEWEST_JOINTS else model.gap.examined
    return typical([changes.get(joint, 0.0) for joint in asked]) < EXACT


def untouched_and_exact(model: Model) -> list[int]:
    """Return the joints that no cause touches, and whose friction is as stated."""
    changes = least_off(model)
    return [joint for joint in _untouched(model) if changes.get(joint, 0.0) < EXACT]


def _untouched(model: Model) -> list[int]:
    touched = {choice.site.joint for choice in model.chosen if not choice.cause.whole_arm}
    return [joint for joint in model.gap.examined if joint not in touched]


def usual_nuisance(gap: Gap) -> Nuisance:
    """Return what is refitted with every candidate along a gap: of drives too, where friction is not stated exactly.

    What data sheets say of drives is as right as friction is: levels that are off throughout are the mark of that.  On
    one joint or two a torque constant that is off looks so too, but with that all levels are as stated.
    """
    nuisance = make_nuisance(gap)
    exact = stated_exactly(build_model(gap, nuisance, ()))
    if not exact and len(gap.examined) < FEWEST_JOINTS:
        constants = tuple(Chosen(TorqueConstant(), Site(joint)) for joint in gap.examined)
        exact = stated_exactly(build_model(gap, nuisance, constants))
    return nuisance if exact else make_nuisance(gap, drives=True)


def held_links(model: Model, field: Field, changes: Mapping[int, float]) -> Model:
    """Return the model with all links as stated and one cause more, where the rest is stated exactly and that leaves as
    little at every joint.

    Links may be a few percent off beside friction levels that are; beside levels that are right to a percent, what
    one link or payload does alone was not done by two dozen small errors.  ``changes`` are what friction is off by
    (:func:`least_off`), by joint, before any was held as stated: one that could not be told is no level that is right.
    """
    if not model.nuisance.links or len(changes) < FEWEST_JOINTS:
        return model
    if typical(list(changes.values())) > EXACT:
        return model
    held = model.without_links()
    links = tuple(one for one in field if isinstance(one.cause, LinkScale))
    asked = tuple(one for one in field if one not in links)
    # A link's four numbers beside a tilt, or another link's, can be nearly anything.
    whole = not any(choice.cause.of_body for choice in model.chosen)
    lone = (LoneLink(), LoneWholeLink()) if whole else (LoneLink(),)
    asked += tuple(replace(one, cause=cause) for one in links for cause in lone)
    able = passing(contenders(held, asked), chances_in(asked))
    if not able:
        return model
    best = max(fairly(held, able), key=lambda trial: trial.merit)
    rest = without_contained(held.chosen, best.chosen)
    alone = straightened(build_model(held.gap, held.nuisance, (*rest, best.chosen)))
    return alone if _as_good(alone, model, held) else model


def _as_good(alone: Model, model: Model, bare: Model) -> bool:
    # At every joint: by what is left, or by what is taken off the error that there is with links as stated.
    gap = model.gap
    lefts = [one.heldout_residual() for one in (alone, model, bare)]
    for joint in gap.examined:
        left, least, whole = (gap.rms(one[:, joint], joint) ** 2 for one in lefts)
        if left > max(AS_GOOD**2 * least, least + (1.0 - NEARLY_ALL) * (whole - least)):
            return False
    return True


def level_changes(model: Model) -> dict[int, float]:
    """Return by how much each joint's friction is refitted, relative to what is stated, by joint.

    A torque constant that is refitted along scales friction too: what counts is what the drive reports of it.
    """
    own = _as_reported(model)
    return {
        level.site.joint: relative_change(model.gap, level.site, own[level.site.joint])
        for level in model.nuisance.levels
    }


def _as_reported(model: Model) -> dict[int, Floats]:
    # By how much each joint's level and damping (2,) are refitted, as its drive reports them.
    nuisance, strengths, table = model.nuisance, model.strengths, model.gap.robot.table.joint
    pairs = zip(nuisance.drives, strengths[nuisance.of_drives], strict=True)
    scale = {drive.site.joint: change for drive, change in pairs if drive.cause.name == TorqueConstant.name}
    joints = [level.site.joint for level in nuisance.levels]
    return {j: strengths[nuisance.of_level(j)] + scale.get(j, 0.0) * np.array(stated_levels(table[j])) for j in joints}


def least_off(model: Model) -> dict[int, float]:
    """Return how far each joint's friction is off short of what noise makes of a fit, relative to what is stated, by
    joint: in all, or in its level or its damping alone, whichever is more.

    In all, noise is taken off as variances are; where it is much, no more than a percent.  Of level and damping it is
    the nearer end of the 95 % interval that counts, where no cause touches the joint: both may be off by more than
    friction is where the motion sees them both, one up, the other down.
    """
    gap, nuisance, changes, untouched = model.gap, model.nuisance, level_changes(model), _untouched(model)
    reported = _as_reported(model)
    covariance = model.system.normal.covariance(model.strengths, gap.blocks.group)
    quantile = float(student.ppf(0.975, gap.blocks.groups - 1))
    out = {}
    for level in nuisance.levels:
        joint, place = level.site.joint, nuisance.of_level(level.site.joint)
        own, stated = covariance[place, place], np.array(stated_levels(gap.robot.table.joint[joint]))
        noise = np.sqrt(np.trace(own @ _mean_square(gap, level.site))) / _stated_friction(gap, joint)
        out[joint] = max(float(np.sqrt(max(changes[joint] ** 2 - noise**2, 0.0))), changes[joint] - EXACT)
        if joint in untouched:
            half = quantile * np.sqrt(np.maximum(np.diag(own), 0.0))
            least = np.maximum(np.abs(reported[joint]) - half, 0.0)
            alone = np.divide(least, stated, out=np.zeros_like(least), where=stated > 0.0)
            out[joint] = max(out[joint], float(np.max(alone)))
    return out


def _mean_square(gap: Gap, site: Site) -> Floats:
    samples = STATED_LEVELS.samples(gap, site)
    return np.asarray(samples.T @ samples / samples.shape[0])


def _stated_friction(gap: Gap, joint: int) -> float:
    return max(float(np.sqrt(np.mean(np.square(gap.effort.friction[:, joint])))), 1e-12)


def relative_change(gap: Gap, site: Site, strengths: Floats) -> float:
    """Return the size of a change of a joint's level and damping (2,), relative to its stated friction."""
    return float(np.sqrt(strengths @ _mean_square(gap, site) @ strengths)) / _stated_friction(gap, site.joint)
