"""Waves and springs that only approximate one curve along the stroke, e.g. that of a hose pulling from one place on."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from mjfriction.diagnose.causes.spring import BentSpring, Spring
from mjfriction.diagnose.causes.waves import Cogging, PositionFriction
from mjfriction.diagnose.fit.intervals import half_widths
from mjfriction.diagnose.fit.model import Chosen, Key, Model
from mjfriction.identify.gap import Gap
from mjfriction.identify.structure import Structure, covariate_rows, curve_share
from mjfriction.record.log import Floats

FEWEST = 2  # fewest causes along the position, at least one of them a wave, that may be one curve
ALONG_STROKE = "one smooth curve along its stroke"
FRICTION_ALONG_STROKE = "friction that differs along its stroke"
KNOWN_TO = 0.2  # relative half-width of a wavenumber's 95 % interval beyond which the wave's period counts as unknown
# Relative tolerance within which a wavenumber is a whole multiple of the longest wave's, where two waves, or more of
# them, are to be harmonics though a smooth curve does as well.
HARMONIC_TWO, HARMONIC = 0.005, 0.01
HIGHEST = 8  # highest such multiple; finer waves are close to some multiple of anything
AS_GOOD = 0.97  # fraction of one fit's reduction of the mean square above which another fit is as good


@dataclass(frozen=True)
class StrokeCurve:
    """A curve along one joint's stroke: the causes that approximate it (``keys``), and its share of the residual
    without them.
    """

    keys: frozenset[Key]
    structure: Structure


def vague_waves(model: Model) -> frozenset[Key]:
    """Return the friction waves whose period is not known to within 20 %, of those that are several on their joint.

    Together they approximate a course of the level along the stroke, or something that snags.
    """
    waves = [choice for choice in model.chosen if isinstance(choice.cause, PositionFriction)]
    joints = [choice.site.joint for choice in waves]
    two = [choice for choice in waves if joints.count(choice.site.joint) > 1]
    widths = _widths(model) if two else {}
    return frozenset(choice.key for choice in two if _vague(choice, widths))


def vague_friction(model: Model, heldout: Floats) -> list[Structure]:
    """Return, for each joint with vague waves, the share that these take of the residual that they leave without them.

    ``heldout`` (rows, joints) is the model's held-out residual.
    """
    gap, waves = model.gap, vague_waves(model)
    without = model
    for choice in model.chosen:
        without = without.without(choice) if choice.key in waves else without
    joints = sorted({choice.site.joint for choice in model.chosen if choice.key in waves})
    before = without.heldout_residual() if joints else heldout
    return [
        Structure(gap.robot.joints[joint], FRICTION_ALONG_STROKE, _taken(gap, joint, before, heldout))
        for joint in joints
    ]


def _taken(gap: Gap, joint: int, before: Floats, after: Floats) -> float:
    return 1.0 - (gap.rms(after[:, joint], joint) / max(gap.rms(before[:, joint], joint), 1e-300)) ** 2


def _widths(model: Model) -> dict[Key, Floats]:
    return dict(zip((choice.key for choice in model.chosen), half_widths(model).causes, strict=True))


def _vague(choice: Chosen, widths: Mapping[Key, Floats]) -> bool:
    return bool(widths[choice.key][-1] > KNOWN_TO * choice.site.shape[0])


def _harmonics(own: list[Chosen]) -> bool:
    # Whether all are waves, at least two, and the shorter ones are harmonics of the longest.  Two may be by chance,
    # unless they are so very nearly.
    if not all(isinstance(choice.cause, Cogging) for choice in own) or len(own) < FEWEST:
        return False
    numbers = np.array([choice.site.shape[0] for choice in own])
    multiples = numbers / np.min(numbers)
    whole = np.round(multiples)
    tolerance = HARMONIC_TWO if len(own) == FEWEST else HARMONIC
    apart = np.unique(whole).size == whole.size
    return bool(apart and np.all(whole <= HIGHEST) and np.all(np.abs(multiples / whole - 1.0) < tolerance))


def stroke_curves(model: Model, heldout: Floats) -> list[StrokeCurve]:
    """Return the curves among a model's causes; ``heldout`` (rows, joints) is the model's held-out residual.

    A single wave is a wave, and so are waves of gears and poles, which are too short for a smooth curve to follow.
    Several waves of a few periods over the stroke, or waves with a spring, are no evidence of gears or poles if one
    smooth curve over position does as well, or if a period is not known to within 20 %.  Harmonics of one wave are
    evidence although a curve does as well: waves that approximate a curve are hardly ever harmonics by chance.  A
    bent spring that does not do as well as a smooth curve is not a spring.
    """
    gap, out = model.gap, []
    widths = _widths(model)
    for joint in gap.examined:
        own = [c for c in model.chosen if c.site.joint == joint and isinstance(c.cause, Cogging | Spring | BentSpring)]
        waves = len(own) >= FEWEST and any(isinstance(choice.cause, Cogging) for choice in own)
        if not waves and not any(isinstance(choice.cause, BentSpring) for choice in own):
            continue
        without = model
        for choice in own:
            without = without.without(choice)
        before = without.heldout_residual()
        taken = _taken(gap, joint, before, heldout)
        share = curve_share(gap, joint, covariate_rows(gap, joint, "position"), before)
        unsure = any(isinstance(choice.cause, Cogging) and _vague(choice, widths) for choice in own)
        curved = share > AS_GOOD * taken and not _harmonics(own)
        if (unsure or curved) if waves else taken < AS_GOOD * share:
            structure = Structure(gap.robot.joints[joint], ALONG_STROKE, share)
            out.append(StrokeCurve(frozenset(choice.key for choice in own), structure))
    return out
