"""Waves and a spring that only spell out a curve along the stroke: of a hose that pulls from one place on, say."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from mjfriction.diagnose.causes.spring import BentSpring, Spring
from mjfriction.diagnose.causes.waves import Cogging, PositionFriction
from mjfriction.diagnose.intervals import half_widths
from mjfriction.diagnose.model import Chosen, Key, Model
from mjfriction.identify.structure import Structure, covariate_rows, curve_share
from mjfriction.record.log import Floats

FEWEST = 2  # causes along the position, waves among them, that may be one curve
ALONG_STROKE = "one smooth curve along its stroke"
KNOWN_TO = 0.2  # of its wavenumber, that a wave's own is known to
FEWEST_HARMONIC = 3  # waves, the longest counted, that are told as harmonics whatever curve does as well
HARMONIC = 0.01  # of its wavenumber, within which a wave's is a whole multiple of the longest one's
HIGHEST = 8  # multiple of it; finer waves are near some multiple of anything
AS_GOOD = 0.97  # of what the one takes off the mean square, that the other takes too


@dataclass(frozen=True)
class StrokeCurve:
    """A curve along one joint's stroke: the causes that spell it (``keys``), and its share of the error without."""

    keys: frozenset[Key]
    structure: Structure


def vague_waves(model: Model) -> frozenset[Key]:
    """Return which waves of friction that are two on their joint have no period that is known to a fifth: a course of
    the level along the stroke that they spell together, or something that snags.
    """
    waves = [choice for choice in model.chosen if isinstance(choice.cause, PositionFriction)]
    joints = [choice.site.joint for choice in waves]
    two = [choice for choice in waves if joints.count(choice.site.joint) > 1]
    widths = _widths(model) if two else {}
    return frozenset(choice.key for choice in two if _vague(choice, widths))


def _widths(model: Model) -> dict[Key, Floats]:
    return dict(zip((choice.key for choice in model.chosen), half_widths(model).causes, strict=True))


def _vague(choice: Chosen, widths: Mapping[Key, Floats]) -> bool:
    return bool(widths[choice.key][-1] > KNOWN_TO * choice.site.shape[0])


def _harmonics(own: list[Chosen]) -> bool:
    # Whether all are waves, three at least, and the shorter ones harmonics of the longest: two may happen to be.
    if not all(isinstance(choice.cause, Cogging) for choice in own) or len(own) < FEWEST_HARMONIC:
        return False
    numbers = np.array([choice.site.shape[0] for choice in own])
    multiples = numbers / np.min(numbers)
    whole = np.round(multiples)
    return bool(np.all(whole <= HIGHEST) and np.all(np.abs(multiples / whole - 1.0) < HARMONIC))


def stroke_curves(model: Model, heldout: Floats) -> list[StrokeCurve]:
    """Return the curves among a model's causes; ``heldout`` (rows, joints) is what it leaves on motion not fitted.

    One wave is a wave, and so are those of gears and poles, too short for a smooth curve to follow.  But several waves
    of a few periods over the stroke, or some with a spring, that one smooth curve over position does as well as, say
    nothing of gears or poles; nor do those of which the period is not known to a fifth.  Harmonics of one wave do: of
    a curve hardly three waves happen to be such.  And a spring that bends, but
    does not do as well as a smooth curve, is none.
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
        taken = 1.0 - (gap.rms(heldout[:, joint], joint) / max(gap.rms(before[:, joint], joint), 1e-300)) ** 2
        share = curve_share(gap, joint, covariate_rows(gap, joint, "position"), before)
        unsure = any(isinstance(choice.cause, Cogging) and _vague(choice, widths) for choice in own)
        curved = share > AS_GOOD * taken and not _harmonics(own)
        if (unsure or curved) if waves else taken < AS_GOOD * share:
            structure = Structure(gap.robot.joints[joint], ALONG_STROKE, share)
            out.append(StrokeCurve(frozenset(choice.key for choice in own), structure))
    return out
