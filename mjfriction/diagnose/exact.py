"""How exactly a robot is stated: by what its friction is off, and may be."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from scipy.stats import t as student

from mjfriction.diagnose.causes.catalog import STATED_LEVELS
from mjfriction.diagnose.causes.cause import Site
from mjfriction.diagnose.causes.torque_constant import TorqueConstant
from mjfriction.diagnose.model import Chosen, Model, build_model
from mjfriction.diagnose.nuisance import Nuisance, make_nuisance
from mjfriction.diagnose.refitted import FEWEST_JOINTS
from mjfriction.identify.gap import Gap
from mjfriction.record.log import Floats
from mjfriction.robot.friction import stated_levels

MOST_JOINTS = 0.75  # share of joints whose changes are typical
EXACT = 0.01  # of the stated friction: typical change of the other joints up to which a robot, links and all, is right
FEWEST_OTHERS = 2  # joints, that can say how far friction usually is off
OUTLYING = 3.0  # times the typical change of what is stated, that a change must be to be no such
UNKNOWN = 0.04  # of the stated friction, that is taken for it where they lack


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
    changes, others = least_off(model) if model.chosen else level_changes(model), untouched(model)
    asked = others if len(others) >= FEWEST_JOINTS else model.gap.examined
    return typical([changes.get(joint, 0.0) for joint in asked]) < EXACT


def untouched_and_exact(model: Model) -> list[int]:
    """Return the joints that no cause touches, and whose friction is as stated."""
    changes = least_off(model)
    return [joint for joint in untouched(model) if changes.get(joint, 0.0) < EXACT]


def untouched(model: Model) -> list[int]:
    """Return the joints that no cause touches, but for those of the whole arm."""
    touched = {choice.site.joint for choice in model.chosen if not choice.cause.whole_arm}
    return [joint for joint in model.gap.examined if joint not in touched]


def usual_nuisance(gap: Gap) -> Nuisance:
    """Return what is refitted with every candidate along a gap: of drives too, where friction is not stated exactly.

    What data sheets say of drives is as right as friction is: levels that are off throughout are the mark of that.  A
    torque constant that is off looks so too, at its own joint and at those that its joint's motion tells of, but with
    that all levels are as stated.
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
    gap, changes, bare = model.gap, level_changes(model), untouched(model)
    reported, covariances = _as_reported(model), _covariances(model)
    quantile = float(student.ppf(0.975, gap.blocks.groups - 1))
    out = {}
    for joint, noise in _noises(model, covariances).items():
        out[joint] = max(float(np.sqrt(max(changes[joint] ** 2 - noise**2, 0.0))), changes[joint] - EXACT)
        if joint in bare:
            stated = np.array(stated_levels(gap.robot.table.joint[joint]))
            half = quantile * np.sqrt(np.maximum(np.diag(covariances[joint]), 0.0))
            least = np.maximum(np.abs(reported[joint]) - half, 0.0)
            alone = np.divide(least, stated, out=np.zeros_like(least), where=stated > 0.0)
            out[joint] = max(out[joint], float(np.max(alone)))
    return out


def may_be_off(model: Model) -> dict[int, float]:
    """Return how far each joint's friction may be off, what noise leaves open included, relative to what is stated, by
    joint.
    """
    changes = level_changes(model)
    return {
        joint: float(np.hypot(changes[joint], noise)) for joint, noise in _noises(model, _covariances(model)).items()
    }


def levels_off(model: Model) -> float:
    """Return by how much levels and dampings are off one by one, relative to what is stated (RMS), short of noise, at
    joints that no cause touches; those held as stated are right.
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
    # Of each joint's level and damping, (2, 2).
    nuisance, joints = model.nuisance, [level.site.joint for level in model.nuisance.levels]
    covariance = model.system.normal.covariance(model.gap.blocks.group)
    return {joint: covariance[nuisance.of_level(joint), nuisance.of_level(joint)] for joint in joints}


def _noises(model: Model, covariances: Mapping[int, Floats]) -> dict[int, float]:
    # What noise makes of each joint's friction, relative to what is stated.
    gap = model.gap
    return {
        joint: float(np.sqrt(np.trace(own @ _mean_square(gap, Site(joint))))) / _stated_friction(gap, joint)
        for joint, own in covariances.items()
    }


def _mean_square(gap: Gap, site: Site) -> Floats:
    samples = STATED_LEVELS.samples(gap, site)
    return np.asarray(samples.T @ samples / samples.shape[0])


def _stated_friction(gap: Gap, joint: int) -> float:
    return max(float(np.sqrt(np.mean(np.square(gap.effort.friction[:, joint])))), 1e-12)


def relative_change(gap: Gap, site: Site, strengths: Floats) -> float:
    """Return the size of a change of a joint's level and damping (2,), relative to its stated friction."""
    return float(np.sqrt(strengths @ _mean_square(gap, site) @ strengths)) / _stated_friction(gap, site.joint)
