"""Both levels of a joint off by one factor: a torque constant may be off by that instead, one number in place of two.

A joint's stated levels agree with each other no better than stated levels do elsewhere on the robot.  So the torque
constant is tried with levels kept as near to what is stated as those of the other joints are.  At a joint that carries
next to nothing, free levels would leave nothing to detect it by.

On a machine of few joints, free links beside free levels leave nothing either.  But that both are off by one factor is
hardly a coincidence, and no more is it that levels undo a factor which only the link needs.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mjfriction.diagnose.causes.cause import Site
from mjfriction.diagnose.causes.links import LinkScale
from mjfriction.diagnose.causes.rotor_inertia import RotorInertia
from mjfriction.diagnose.causes.torque_constant import TorqueConstant
from mjfriction.diagnose.fit.as_little import leaves_as_little
from mjfriction.diagnose.fit.exact import EXACT, usually_off
from mjfriction.diagnose.fit.model import Chosen, Model, build_model
from mjfriction.diagnose.fit.nuisance import FARTHEST
from mjfriction.diagnose.fit.refitted import FEWEST_JOINTS
from mjfriction.diagnose.fit.trial import Trial
from mjfriction.record.log import Floats
from mjfriction.robot.friction import stated_levels

# Times the sensor's noise that may be left of an effort which one factor explains: of what no cause fits, factors,
# links and levels all fit a part.
CLEAN = 1.5
LEAST_OFF = 0.04  # a torque constant that is off by less is not worth a name in place of levels


@dataclass(frozen=True)
class Scaled:
    """A model in which a torque constant replaces the change of both levels of a joint.

    The levels are kept near what is stated by ``spread``, the relative deviation of levels elsewhere.  ``one_factor``
    says that they are no farther off than that, or that the torque constant replaces a change of the rotor as well.
    """

    model: Model
    spread: float
    one_factor: bool


def scaled_levels(model: Model, held: Model, own: Trial, change: dict[int, float]) -> Scaled | None:
    """Return the model with a torque constant in place of a joint's levels; ``own`` is the trial of these levels in
    ``held``, the model that holds them as stated.

    None if the torque constant is in ``model`` already, is not admissible, is off by no more than is usual, does not
    leave as little, or needs levels that are farther off than any are.  ``change`` is how far each joint's friction is
    off, relative to what is stated, by joint.
    """
    joint = own.chosen.site.joint
    factor, rotor = Chosen(TorqueConstant(), Site(joint)), (RotorInertia.name, joint, 0)
    if factor.key in {choice.key for choice in model.chosen}:
        return None
    free = held.with_also(own.chosen)
    spread = _spread(change, joint)
    # If the rotor inertia is off by the same factor, the torque constant replaces that number too.
    fewer = tuple(choice for choice in held.chosen if choice.key != rotor)
    for rest in (fewer, held.chosen) if len(fewer) < len(held.chosen) else (fewer,):
        near, moved = _near(build_model(model.gap, model.nuisance, (*rest, factor)), joint, spread)
        if _possible(near, factor) and np.all(moved <= FARTHEST**2) and leaves_as_little(near, free):
            return Scaled(near, spread, bool(np.mean(moved) <= 1.0) or len(rest) < len(held.chosen))
    return None


def beside_factors(model: Model, change: dict[int, float]) -> tuple[Model, dict[int, float]]:
    """Return a model with levels kept near what is stated wherever a torque constant was chosen but free levels alone
    do as well, and the spread that they are kept to, by joint.

    They are kept as near as those of the other joints are; ``change`` is as in :func:`scaled_levels`.
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


def one_number(model: Model) -> Model:
    """Return a model with one number in place of several that are off by about one factor, on a machine with too few
    joints to tell how exactly it is stated.

    A torque constant takes the place of a joint's levels and of all links, which are then as stated like the drives,
    where that leaves as little, and hardly more than noise, and neither levels nor links alone do.  A link takes the
    place of a torque constant beside levels that undo it.
    """
    if len(model.gap.examined) >= FEWEST_JOINTS or not model.nuisance.links:
        return model
    nuisance, left = model.nuisance.without_drives(), model.heldout_residual()
    for level in nuisance.levels:
        joint = level.site.joint
        if model.gap.rms(left[:, joint], joint) > CLEAN * model.gap.noise_floor[joint]:
            continue
        factor, stated = Chosen(TorqueConstant(), Site(joint)), nuisance.without_level(joint)
        rest = tuple(choice for choice in model.chosen if choice.key != factor.key)
        held = build_model(model.gap, stated.without_links(), rest)
        # Refitted links are kept near what is stated; a link that is far off has to compete as a cause.
        links = [held.with_also(Chosen(LinkScale(), site)) for site in LinkScale().sites(model.gap)]
        of_link = next((there for there in links if leaves_as_little(there, model)), None)
        scaled = held.with_also(factor)
        by_factor = leaves_as_little(scaled, model) and _possible(scaled, factor)
        if len(rest) < len(model.chosen):
            if of_link is not None and not by_factor:
                return of_link
        elif by_factor and of_link is None:
            halves = [build_model(model.gap, half, rest) for half in (nuisance.without_links(), stated)]
            if not any(leaves_as_little(half, scaled) for half in halves):
                return scaled
    return model


def _possible(model: Model, factor: Chosen) -> bool:
    strength = model.strengths_of(factor)
    return factor.cause.admissible(model.gap, factor.site, strength) and not _common(model, factor)


def with_factor(model: Model, joint: int, spread: float) -> Model:
    """Return a model with a torque constant in place of a joint's levels, which are kept near what is stated by
    ``spread``.
    """
    factor = Chosen(TorqueConstant(), Site(joint))
    return _near(model.with_also(factor), joint, spread)[0]


def near_stated(model: Model, joint: int, change: dict[int, float]) -> Model:
    """Return a model with a joint's levels kept as near to what is stated as those of the other joints are; ``change``
    is as in :func:`scaled_levels`.
    """
    return _near(model, joint, _spread(change, joint))[0]


def _spread(change: dict[int, float], joint: int) -> float:
    return max(EXACT, usually_off(change, joint))


def _near(model: Model, joint: int, spread: float) -> tuple[Model, Floats]:
    # The model with a joint's levels kept near what is stated, and the squares (2,) of how many spreads they are off.
    stated = stated_levels(model.gap.robot.table.joint[joint])
    near = build_model(model.gap, model.nuisance.with_level_near(joint, stated, spread), model.chosen)
    place = near.nuisance.of_level(joint)
    return near, near.nuisance.precision[place] * np.square(near.strengths[place])


def _common(model: Model, choice: Chosen) -> bool:
    # Whether a torque constant's change is within what such stated values are off by on any robot.
    return bool(abs(float(model.strengths_of(choice)[0])) < LEAST_OFF)
