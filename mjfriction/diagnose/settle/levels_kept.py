"""Causes and shapes that free friction levels make up for, refitted beside levels held as stated.

What a shared drive takes of a joint's own velocity looks like that joint's damping, so with free levels any ratio fits.
A torque constant of half its value beside twice the friction fits like a link of half its mass. Where levels can stay
as stated, nothing else needs to be wrong.
"""

from __future__ import annotations

from dataclasses import replace

from mjfriction.diagnose.causes.asymmetry import Asymmetry
from mjfriction.diagnose.causes.carried_drive import CarriedDrive
from mjfriction.diagnose.causes.cause import Site
from mjfriction.diagnose.causes.coupling import RATIOS, SharedDrive
from mjfriction.diagnose.causes.waves import PositionFriction
from mjfriction.diagnose.fit.as_little import leaves_as_little
from mjfriction.diagnose.fit.exact import EXACT, level_changes, usually_off
from mjfriction.diagnose.fit.model import Chosen, Model, build_model, cause_block, without_contained
from mjfriction.diagnose.fit.shapes import best_shape, reshaped
from mjfriction.diagnose.fit.trial import try_out
from mjfriction.diagnose.search.exchange import for_place_of
from mjfriction.diagnose.search.field import Field, chances_in
from mjfriction.diagnose.search.refusal import BENDING
from mjfriction.diagnose.search.short_list import contenders, fairly, passing
from mjfriction.robot.friction import stated_levels

ROUNDS = 2
LEAST_OFF = 0.04  # relative change of friction from which levels beside a drive are doubted
NEARER = 0.5  # share of that change that another drive may leave
# Causes beside which level and damping depend on how the friction curve is parametrised.  An asymmetry between the
# directions is not one of them: it is even in velocity, and levels are odd.
CURVES = BENDING - {Asymmetry.name}
WITH_LEVELS = CURVES | {PositionFriction.name}


def with_levels_as_stated(model: Model) -> Model:
    """Return the model with levels held as stated wherever free ones make up for a cause's shape, and that shape
    refitted beside them, where this does as well.
    """
    for choice in model.chosen:
        bounds = choice.cause.bounds_beside_stated_levels(model.gap, choice.site)
        if bounds:
            model = _reshaped(model, choice, bounds)
    return model


def _reshaped(model: Model, choice: Chosen, bounds: list[tuple[float, float]]) -> Model:
    gap, felt, kept = model.gap, cause_block(model.gap, choice)[0].keys(), model.nuisance
    own = replace(choice, site=choice.site.shaped(choice.site.shape or tuple(1.0 for _ in bounds)))
    for joint in felt:
        kept = kept.without_level(joint)
    held = build_model(gap, kept, model.without(choice).chosen)
    for _ in range(ROUNDS):
        # With levels held, curves near rest take other shapes, beside which this cause's shape is searched again.
        own = best_shape(held, own, bounds)
        if try_out(held, own) is None:
            return model
        there = reshaped(build_model(gap, kept, (*held.chosen, own)), felt)
        held = there.without(own)
    return there if leaves_as_little(there, model, felt) else model


def drives_besides(model: Model) -> Model:
    """Return the model with drives of their own in the place of joints' drives that turn with their neighbours too,
    where levels are then nearer to what is stated and this leaves as little at both joints.

    With free levels, both fit alike at any ratio: a joint's own drive that also turns with its neighbour, and takes as
    much of the stated friction as the refitted levels add, is an additional drive.  Ratios are searched beside levels
    that are kept as near to what is stated as those of other joints are, 1 first.
    """
    for choice in model.chosen:
        if isinstance(choice.cause, CarriedDrive):
            pair = sorted(cause_block(model.gap, choice)[0])
            off = _off(model, pair)
            if off > LEAST_OFF:
                drives = [_besides(model, choice, drive(), pair, NEARER * off) for drive in choice.cause.besides]
                found = [one for one in drives if one is not None]
                model = min(found, key=lambda one: _off(one, pair), default=model)
    return model


def _off(model: Model, joints: list[int]) -> float:
    # Where no friction is stated, any is infinitely far from it, which says nothing of a drive.
    changes, table = level_changes(model), model.gap.robot.table.joint
    return max((changes.get(joint, 0.0) for joint in joints if any(stated_levels(table[joint]))), default=0.0)


def _besides(model: Model, choice: Chosen, drive: SharedDrive, pair: list[int], most: float) -> Model | None:
    # None where no ratio leaves as little, with the levels of the pair off by less than ``most``.
    gap, near, changes = model.gap, model.nuisance, level_changes(model)
    for joint in pair:
        stated = stated_levels(gap.robot.table.joint[joint])
        others = {one: change for one, change in changes.items() if one not in pair or one == joint}
        near = near.with_level_near(joint, stated, max(usually_off(others, joint), EXACT))
    rest = model.without(choice).chosen
    held, equal = build_model(gap, near, rest), Chosen(drive, Site(pair[0], other=pair[1]))
    geared = best_shape(held, replace(equal, site=equal.site.shaped((1.0,))), [RATIOS])
    for own in (equal, geared):
        there = build_model(gap, model.nuisance, (*rest, own))
        if _off(there, pair) < most and there.admissible() is there and leaves_as_little(there, model, pair):
            return there
    return None


def one_for_both(model: Model, joint: int, field: Field) -> Model | None:
    """Return the model with one cause in the place of both a cause on a joint and the joint's refitted levels, which
    are held as stated; None where no such cause leaves as little everywhere.
    """
    gap, kept = model.gap, model.nuisance.without_level(joint)
    for choice in model.noteworthy:
        if choice.site.joint != joint:
            continue
        held = build_model(gap, kept, model.without(choice).chosen)
        rivals = fairly(held, contenders(held, for_place_of(choice, field)))
        able = [
            one for one in passing(rivals, chances_in(field)) if leaves_as_little(held.with_also(one.chosen), model)
        ]
        if able:
            best = max(able, key=lambda trial: trial.merit).chosen
            return build_model(gap, kept, (*without_contained(held.chosen, best), best))
    return None
