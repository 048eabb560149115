"""Both levels of a joint off by one factor: what its drive reports may be off by that instead, one number for two.

Stated levels agree with each other no better than they do elsewhere on the robot, so that a torque constant is tried
with levels as near what is stated as those of other joints are.  At a joint that carries next to nothing free levels
leave nothing to tell it by.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mjfriction.diagnose.as_little import leaves_as_little
from mjfriction.diagnose.causes.cause import Site
from mjfriction.diagnose.causes.rotor_inertia import RotorInertia
from mjfriction.diagnose.causes.torque_constant import TorqueConstant
from mjfriction.diagnose.exact import EXACT, usually_off
from mjfriction.diagnose.model import Chosen, Model, build_model
from mjfriction.diagnose.nuisance import FARTHEST
from mjfriction.diagnose.trial import Trial
from mjfriction.record.log import Floats
from mjfriction.robot.friction import stated_levels


@dataclass(frozen=True)
class Scaled:
    """A model in which a torque constant does what both levels of a joint do, these as near what is stated as levels
    are elsewhere, which is a ``spread``; ``one_factor`` says that they are no farther from it than that.
    """

    model: Model
    spread: float
    one_factor: bool


def scaled_levels(model: Model, held: Model, own: Trial, change: dict[int, float]) -> Scaled | None:
    """Return what a torque constant comes to in the place of a joint's levels, which were tried as ``own`` beside a
    model that has them as stated, ``held``; None where it does not leave as little, or needs levels that are farther
    off than any.

    ``change`` is by how much each joint's friction is off, by joint.
    """
    joint = own.chosen.site.joint
    factor, rotor = Chosen(TorqueConstant(), Site(joint)), (RotorInertia.name, joint, 0)
    if factor.key in {choice.key for choice in model.chosen}:
        return None
    free = held.with_also(own.chosen)
    spread = _spread(change, joint)
    # A rotor that is off by the same factor is one number more that it does away with.
    fewer = tuple(choice for choice in held.chosen if choice.key != rotor)
    for rest in (fewer, held.chosen) if len(fewer) < len(held.chosen) else (fewer,):
        near, moved = _near(build_model(model.gap, model.nuisance, (*rest, factor)), joint, spread)
        strength = near.strengths[near.places[-1]]
        possible = factor.cause.admissible(model.gap, factor.site, strength) and not _common(near, factor)
        if possible and np.all(moved <= FARTHEST**2) and leaves_as_little(near, free):
            return Scaled(near, spread, bool(np.mean(moved) <= 1.0) or len(rest) < len(held.chosen))
    return None


def beside_factors(model: Model, change: dict[int, float]) -> tuple[Model, dict[int, float]]:
    """Return a model with levels as near what is stated as others are, wherever a torque constant was chosen that free
    levels would do as well without, and how near that is, by joint; ``change`` as in :func:`scaled_levels`.
    """
    alike: dict[int, float] = {}
    for level in model.nuisance.levels:
        joint = level.site.joint
        for choice in model.chosen:
            if choice.key != (TorqueConstant.name, joint, 0) or _common(model, choice):
                continue
            near, moved = _near(model, joint, _spread(change, joint))
            without = model.without(choice)
            if np.all(moved <= FARTHEST**2) and leaves_as_little(near, model) and leaves_as_little(without, near):
                model = near
                alike[joint] = _spread(change, joint)
    return model, alike


def with_factor(model: Model, joint: int, spread: float) -> Model:
    """Return a model with a torque constant in the place of a joint's levels, which are within a ``spread`` of what is
    stated.
    """
    factor = Chosen(TorqueConstant(), Site(joint))
    return _near(model.with_also(factor), joint, spread)[0]


def _spread(change: dict[int, float], joint: int) -> float:
    return max(EXACT, usually_off(change, joint))


def _near(model: Model, joint: int, spread: float) -> tuple[Model, Floats]:
    # The model with a joint's levels as near what is stated as others are, and how far they are from it, (2,) squares.
    stated = stated_levels(model.gap.robot.table.joint[joint])
    near = build_model(model.gap, model.nuisance.with_level_near(joint, stated, spread), model.chosen)
    place = near.nuisance.of_level(joint)
    return near, near.nuisance.precision[place] * np.square(near.strengths[place])


def _common(model: Model, choice: Chosen) -> bool:
    # Off by no more than such stated values are on any robot.
    place = model.places[[one.key for one in model.chosen].index(choice.key)]
    return choice.cause.usual(model.gap, choice.site, model.strengths[place])
