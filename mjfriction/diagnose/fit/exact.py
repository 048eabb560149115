"""How exactly a robot is stated: how far its friction is off, and how far it may be."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from scipy.stats import t as student

from mjfriction.diagnose.causes.catalog import STATED_LEVELS
from mjfriction.diagnose.causes.cause import Site
from mjfriction.diagnose.causes.torque_constant import TorqueConstant
from mjfriction.diagnose.fit.model import Chosen, Model, build_model
from mjfriction.diagnose.fit.nuisance import Nuisance, make_nuisance
from mjfriction.diagnose.fit.refitted import FEWEST_JOINTS
from mjfriction.identify.gap import Gap
from mjfriction.record.log import Floats
from mjfriction.robot.friction import stated_levels

MOST_JOINTS = 0.75  # quantile over the joints that is taken as the typical change
EXACT = 0.01  # of the stated friction: up to this typical change a robot is taken to be stated exactly, links and all
FEWEST_OTHERS = 2  # other joints that are needed to say how far friction usually is off
OUTLYING = 3.0  # a change stands out where it exceeds the typical change of stated values by this factor
UNKNOWN = 0.04  # of the stated friction: assumed typical change where too few other joints can say


def typical(changes: Sequence[float], *, at_least: bool = False) -> float:
    """Return the change that most joints stay below, a quantile.

    With ``at_least``, it is not interpolated: it is the largest change of a joint at or below that quantile.
    """
    return float(np.quantile(changes, MOST_JOINTS, method="lower" if at_least else "linear"))


def usually_off(changes: Mapping[int, float], joint: int, *, at_least: bool = False) -> float:
    """Return how far the friction of the joints beside one typically is off; a few percent where too few can say.

    ``at_least`` is for few joints: of two or three others, one that is far off says nothing about the rest.
    """
    others = [value for other, value in changes.items() if other != joint]
    return typical(others, at_least=at_least) if len(others) >= FEWEST_OTHERS else UNKNOWN


def stated_exactly(model: Model) -> bool:
    """Return whether friction is as stated at nearly all joints, so that the other stated values can be trusted too.

    What a cause leaves of its joint's friction depends on the cause's form, so the joints without causes decide where
    there are enough of them. Before any cause is found, unexplained causes may be what makes a fit uncertain. That is
    no reason to trust the stated values, so noise is then not subtracted from the changes.
    """
    changes, others = least_off(model) if model.chosen else level_changes(model), untouched(model)
    asked = others if len(others) >= FEWEST_JOINTS else model.gap.examined
    return typical([changes.get(joint, 0.0) for joint in asked]) < EXACT


def untouched_and_exact(model: Model) -> list[int]:
    """Return the joints that no cause touches and whose friction is as stated."""
    changes = least_off(model)
    return [joint for joint in untouched(model) if changes.get(joint, 0.0) < EXACT]


def untouched(model: Model) -> list[int]:
    """Return the examined joints that no cause touches, causes of the whole arm not counted."""
    touched = {choice.site.joint for choice in model.chosen if not choice.cause.whole_arm}
    return [joint for joint in model.gap.examined if joint not in touched]


def usual_nuisance(gap: Gap) -> Nuisance:
    """Return what is refitted with every candidate along a gap, drives included where friction is not stated exactly.

    Data sheets of drives are assumed to be as accurate as friction levels: levels that are off throughout indicate that
    drives are off too. A torque constant that is off makes levels look off as well, at its own joint and at joints that
    are coupled to it. But once it is refitted, all levels are as stated, so levels are also judged beside refitted
    torque constants or drives.
    """
    nuisance = make_nuisance(gap)
    exact = stated_exactly(build_model(gap, nuisance, ()))
    if not exact and len(gap.examined) < FEWEST_JOINTS:
        constants = tuple(Chosen(TorqueConstant(), Site(joint)) for joint in gap.examined)
        exact = stated_exactly(build_model(gap, nuisance, constants))
    let_go = make_nuisance(gap, drives=True)
    if not exact and len(gap.examined) >= FEWEST_JOINTS:
        exact = stated_exactly(build_model(gap, let_go, ()))
    return nuisance if exact else let_go


def level_changes(model: Model) -> dict[int, float]:
    """Return by how much each joint's friction is refitted, relative to what is stated, by joint.

    A torque constant that is refitted along scales friction too: what counts is the friction that the drive reports.
    """
    own = _as_reported(model)
    return {
        level.site.joint: relative_change(model.gap, level.site, own[level.site.joint])
        for level in model.nuisance.levels
    }


def _as_reported(model: Model) -> dict[int, Floats]:
    # The change of each joint's level and damping (2,), as its drive reports them.
    nuisance, strengths, table = model.nuisance, model.strengths, model.gap.robot.table.joint
    pairs = zip(nuisance.drives, strengths[nuisance.of_drives], strict=True)
    scale = {drive.site.joint: change for drive, change in pairs if drive.cause.name == TorqueConstant.name}
    joints = [level.site.joint for level in nuisance.levels]
    return {j: strengths[nuisance.of_level(j)] + scale.get(j, 0.0) * np.array(stated_levels(table[j])) for j in joints}


def least_off(model: Model) -> dict[int, float]:
    """Return how far each joint's friction is off at least, with noise taken off, relative to what is stated, by joint.

    It is the larger of two measures: that of level and damping together, and that of either alone. Together, the noise
    variance is subtracted from the squared change, which takes off at most a percent of friction. Alone, the end of the
    95 % interval that is nearer to zero counts, and only where no cause touches the joint: where the motion shows both,
    one may be too high and the other too low, each by more than friction as a whole.
    """
    gap, changes, bare = model.gap, level_changes(model), untouched(model)
    reported, covariances = _as_reported(model), _covariances(model)
    out = {}
    for joint, noise in _noises(model, covariances).items():
        out[joint] = max(float(np.sqrt(max(changes[joint] ** 2 - noise**2, 0.0))), changes[joint] - EXACT)
        if joint in bare:
            stated = np.array(stated_levels(gap.robot.table.joint[joint]))
            least = np.maximum(np.abs(reported[joint]) - _half_widths(gap, covariances[joint]), 0.0)
            alone = np.divide(least, stated, out=np.zeros_like(least), where=stated > 0.0)
            out[joint] = max(out[joint], float(np.max(alone)))
    return out


def surely_exact(model: Model, within: float) -> bool:
    """Return whether every level and damping that is stated is surely right ``within`` a relative change: refitted
    beside the model's causes, the whole 95 % interval of each is.
    """
    free = build_model(model.gap, make_nuisance(model.gap), model.chosen)
    changes, covariances = _as_reported(free), _covariances(free)
    for joint, change in changes.items():
        stated = np.array(stated_levels(model.gap.robot.table.joint[joint]))
        most = np.abs(change) + _half_widths(model.gap, covariances[joint])
        if np.any((most > within * stated) & (stated > 0.0)):
            return False
    return bool(changes)


def may_be_off(model: Model) -> dict[int, float]:
    """Return how far each joint's friction may be off, including what noise leaves open, relative to what is stated, by
    joint.
    """
    changes = level_changes(model)
    return {
        joint: float(np.hypot(changes[joint], noise)) for joint, noise in _noises(model, _covariances(model)).items()
    }


def levels_off(model: Model) -> float:
    """Return the RMS change of single levels and dampings, relative to what is stated, with the noise variance
    subtracted.

    Only joints that no cause touches count; levels held as stated count as exact.
    """
    reported, covariances, asked = _as_reported(model), _covariances(model), untouched(model)
    squares = []
    for joint, change in reported.items():
        stated = np.array(stated_levels(model.gap.robot.table.joint[joint]))
        there = (stated > 0.0) & (joint in asked)
        squares.extend((np.square(change) - np.diag(covariances[joint]))[there] / np.square(stated[there]))
    held = 2 * sum(joint not in reported for joint in asked)
    return float(np.sqrt(max(np.sum(squares), 0.0) / max(len(squares) + held, 1)))


def _covariances(model: Model) -> dict[int, Floats]:
    # The covariance of each joint's level and damping, (2, 2).
    nuisance, joints = model.nuisance, [level.site.joint for level in model.nuisance.levels]
    covariance = model.system.normal.covariance(model.gap.blocks.group)
    return {joint: covariance[nuisance.of_level(joint), nuisance.of_level(joint)] for joint in joints}


def _half_widths(gap: Gap, covariance: Floats) -> Floats:
    # Of the 95 % intervals of a joint's level and damping, (2,).
    quantile = float(student.ppf(0.975, gap.blocks.groups - 1))
    return np.asarray(quantile * np.sqrt(np.maximum(np.diag(covariance), 0.0)))


def _noises(model: Model, covariances: Mapping[int, Floats]) -> dict[int, float]:
    # The RMS change of each joint's friction that noise makes, relative to what is stated.
    gap = model.gap
    return {
        joint: float(np.sqrt(max(np.trace(own @ _mean_square(gap, Site(joint))), 0.0))) / _stated_friction(gap, joint)
        for joint, own in covariances.items()
    }


def _mean_square(gap: Gap, site: Site) -> Floats:
    samples = STATED_LEVELS.samples(gap, site)
    return np.asarray(samples.T @ samples / samples.shape[0])


def _stated_friction(gap: Gap, joint: int) -> float:
    return max(float(np.sqrt(np.mean(np.square(gap.effort.friction[:, joint])))), 1e-12)


def relative_change(gap: Gap, site: Site, strengths: Floats) -> float:
    """Return the RMS effort of a change of a joint's level and damping (2,), relative to its stated friction."""
    return float(np.sqrt(strengths @ _mean_square(gap, site) @ strengths)) / _stated_friction(gap, site.joint)
