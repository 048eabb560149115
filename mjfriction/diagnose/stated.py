"""Which stated values to move, and when a moved friction level is a finding of its own."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mjfriction.diagnose.causes.catalog import STATED_LEVELS
from mjfriction.diagnose.causes.cause import Site
from mjfriction.diagnose.causes.torque_constant import TorqueConstant
from mjfriction.diagnose.causes.varying import Step, Warming, WarmUpDrift
from mjfriction.diagnose.causes.waves import PositionFriction
from mjfriction.diagnose.exact import AS_GOOD, EXACT, held_links, level_changes, relative_change, typical
from mjfriction.diagnose.field import Field, in_place_of_levels, size
from mjfriction.diagnose.model import Chosen, Model, build_model
from mjfriction.diagnose.nuisance import FARTHEST, Level
from mjfriction.diagnose.refusal import BENDING
from mjfriction.diagnose.shapes import reshaped
from mjfriction.diagnose.short_list import contenders
from mjfriction.diagnose.trial import FALSE_ALARM, Trial, try_out
from mjfriction.record.log import Floats
from mjfriction.robot.friction import stated_levels

MOST_LINK_CHANGE = 0.8  # past which a scaled link is no link any more, and the fit a sign of something else
LEAST_CHANGE = 0.04  # that counts on a robot stated exactly
LEAST_CHANGE_ROUGH = 0.10  # that counts on a robot whose joints are all a little off, or that has too few to compare
OUTLYING = 3.0  # times the typical change that it must be there besides
AS_MUCH = 1.0  # of the stated friction: no way of writing a curve down makes up for that
ALWAYS = 0.25  # of the stated friction: a quarter off is a finding whatever the others are
MOMENTS = 61  # of a course, its own length before and after it included, of which stated levels may be
FEWEST_OTHERS = 2  # joints, that can say how far friction usually is off
BAR = 2.0  # standard errors by which drives, or links, that are let go must help on motion not fitted


@dataclass(frozen=True)
class Settled:
    """The final model, and those of its friction levels that are findings; ``scaled`` are the joints at which both
    levels are off by about one factor, which their drives' torque constants may be off by instead.
    """

    model: Model
    levels: tuple[Chosen, ...]
    scaled: frozenset[int] = frozenset()


def settle(model: Model, field: Field) -> Settled:
    """Keep of the refitted values those that help on motion not fitted; name the friction levels that are findings.

    A level is a finding when it helps beyond chance and by enough to matter, and when its change stands out: more than
    4 % of the stated friction on a robot stated exactly, more than 10 % and than three times what is typical where the
    other joints are a little off too, or a quarter in any case; where friction follows temperature or settles, none of
    this at any moment of that course.  Where another cause does
    as much with fewer freedoms (a torque constant scales both levels alike), that cause takes its place and the level
    stays as stated.  Refitted links are held where one cause does as well and all else is stated exactly.
    """
    field_size = len(model.nuisance.levels)
    change = level_changes(model)
    model, alike = _beside_factors(model, change)
    findings: list[Chosen] = []
    for level in model.nuisance.levels:
        joint = level.site.joint
        if level.near:
            continue
        if _bent(model, joint) and change[joint] > _bar(change, joint):
            unbent = _unbent(model, joint, field)
            if unbent is not None:
                model = unbent
                continue
        held = reshaped(build_model(model.gap, model.nuisance.without_level(joint), model.chosen), {joint})
        trial = try_out(held, Chosen(STATED_LEVELS, level.site))
        if trial is None or trial.chance > FALSE_ALARM or trial.gain <= 0.0:
            model = held
        elif trial.passes(field_size) and change[joint] > _bar(change, joint):
            rival = _simpler(held, trial, field)
            scaled = _scaled(model, held, trial, change) if rival is None else None
            if rival is not None:
                model = build_model(held.gap, held.nuisance, (*held.chosen, rival))
            elif scaled is not None and scaled.one_factor:
                model = scaled.model
            elif _own(model, level, change):
                findings.append(trial.chosen)
            alike |= {joint} if scaled is not None else set()
    if model.nuisance.drives and not _helps(model, model.nuisance.of_drives):
        model = model.without_drives()
    model = held_links(model, field, change) if _links_help(model) else model.without_links()
    # Holding levels moves what is left.
    return Settled(model.admissible(), tuple(findings), frozenset(alike))


def _bent(model: Model, joint: int) -> bool:
    # Where a cause bends the curve over speed, or lets the level vary along a stroke of which the motion sees a part,
    # what is left to level and damping is a matter of its basis.
    return any(
        choice.site.joint == joint
        and choice.cause.name in BENDING | {PositionFriction.name}
        and choice.cause.noteworthy(model.gap, choice.site, model.strengths[place])
        for choice, place in zip(model.chosen, model.places, strict=True)
    )


def _unbent(model: Model, joint: int, field: Field) -> Model | None:
    # Levels and damping that are off, and a bend besides, may together be one curve that motion does not see the end
    # of.  Where that leaves as little, it is the simpler.
    bends = [choice for choice in model.chosen if choice.site.joint == joint and choice.cause.name in BENDING]
    rest = tuple(choice for choice in model.chosen if choice not in bends)
    held = build_model(model.gap, model.nuisance.without_level(joint), rest)
    trials = contenders(held, in_place_of_levels(model.gap, joint)) if bends else []
    whole = model.gap.rms(model.heldout_residual()[:, joint], joint)
    for trial in trials:
        if trial.passes(size(field)) and _left_with(held, trial) < AS_GOOD * whole:
            return build_model(held.gap, held.nuisance, (*rest, trial.chosen))
    return None


def _own(model: Model, level: Level, change: dict[int, float]) -> bool:
    # Whether levels that are off are so by themselves: not as a bend's basis, nor at another time than that of the log.
    joint = level.site.joint
    bent = _bent(model, joint) and change[joint] < AS_MUCH
    return not bent and not _of_another_time(model, level, _bar(change, joint))


def _of_another_time(model: Model, level: Level, bar: float) -> bool:
    # Where friction follows temperature or settles, it is as stated at some moment, be it before or after the log, and
    # where it steps, before or after that: of which one the stated values are, warm or cold, is no error.
    gap, joint = model.gap, level.site.joint
    change = model.strengths[model.nuisance.of_level(joint)]
    for choice, place in zip(model.chosen, model.places, strict=True):
        if choice.site.joint == joint and isinstance(choice.cause, Warming | WarmUpDrift | Step):
            course = choice.cause.course(gap, choice.site)
            beyond = 0.0 if isinstance(choice.cause, Step) else np.ptp(course)
            moments = np.linspace(np.min(course) - beyond, np.max(course) + beyond, MOMENTS)
            own = model.strengths[place]
            if min(relative_change(gap, level.site, change + moment * own) for moment in moments) <= bar:
                return True
    return False


def _simpler(held: Model, own: Trial, field: Field) -> Chosen | None:
    joint = own.chosen.site.joint
    here = tuple(entrant for entrant in field if entrant.joint == joint) + in_place_of_levels(held.gap, joint)
    rivals = [trial for trial in contenders(held, here) if trial.passes(size(field)) and trial.merit > own.merit]
    best = max(rivals, key=lambda trial: trial.merit, default=None)
    return best.chosen if best is not None and _left_with(held, best) < AS_GOOD * _left_with(held, own) else None


@dataclass(frozen=True)
class _Scaled:
    """A model in which a torque constant does what both levels of a joint do, these as near what is stated as levels
    are elsewhere; ``one_factor`` says that they are no farther from it than that.
    """

    model: Model
    one_factor: bool


def _scaled(model: Model, held: Model, own: Trial, change: dict[int, float]) -> _Scaled | None:
    # Both levels off by one factor, as far as stated levels ever agree with each other: what the drive reports may be
    # off by that factor, one number for two.
    joint = own.chosen.site.joint
    factor = Chosen(TorqueConstant(), Site(joint))
    if factor.key in {choice.key for choice in model.chosen}:
        return None
    near, moved = _near(build_model(model.gap, model.nuisance, (*held.chosen, factor)), joint, change)
    strength = near.strengths[near.places[-1]]
    if not factor.cause.admissible(model.gap, factor.site, strength) or _common(near, factor):
        return None
    free = build_model(held.gap, held.nuisance, (*held.chosen, own.chosen))
    if np.any(moved > FARTHEST**2) or not _leaves_as_little(near, free):
        return None
    return _Scaled(near, bool(np.mean(moved) <= 1.0))


def _beside_factors(model: Model, change: dict[int, float]) -> tuple[Model, set[int]]:
    # Where a torque constant was chosen that free levels would have done as well without, these are as near what is
    # stated as others are, that it can be told from them at all; also returns where that is.
    alike: set[int] = set()
    for level in model.nuisance.levels:
        joint = level.site.joint
        for choice in model.chosen:
            if choice.key != (TorqueConstant.name, joint, 0) or _common(model, choice):
                continue
            near, moved = _near(model, joint, change)
            without = model.without(choice)
            if np.all(moved <= FARTHEST**2) and _leaves_as_little(near, model) and _leaves_as_little(without, near):
                model = near
                alike.add(joint)
    return model, alike


def _near(model: Model, joint: int, change: dict[int, float]) -> tuple[Model, Floats]:
    # The model with a joint's levels as near what is stated as others are, and how far they are from it, (2,) squares.
    spread = max(EXACT, _usually_off(change, joint))
    stated = stated_levels(model.gap.robot.table.joint[joint])
    near = build_model(model.gap, model.nuisance.with_level_near(joint, stated, spread), model.chosen)
    place = near.nuisance.of_level(joint)
    return near, near.nuisance.precision[place] * np.square(near.strengths[place])


def _common(model: Model, choice: Chosen) -> bool:
    # Off by no more than such stated values are on any robot.
    place = model.places[[one.key for one in model.chosen].index(choice.key)]
    return choice.cause.usual(model.gap, choice.site, model.strengths[place])


def _leaves_as_little(model: Model, other: Model) -> bool:
    # At every joint, on motion not fitted.
    lefts = model.heldout_residual(), other.heldout_residual()
    gap = model.gap
    return all(gap.rms(lefts[0][:, j], j) < AS_GOOD * gap.rms(lefts[1][:, j], j) for j in gap.examined)


def _left_with(held: Model, trial: Trial) -> float:
    # At the joint whose levels are asked for: what takes more off others' errors is no reason to leave its own.
    model, joint = build_model(held.gap, held.nuisance, (*held.chosen, trial.chosen)), trial.chosen.site.joint
    return held.gap.rms(model.heldout_residual()[:, joint], joint)


def _links_help(model: Model) -> bool:
    if model.nuisance.inertias is not None:
        return _helps(model, model.nuisance.of_inertias)
    if not model.nuisance.links or np.any(np.abs(model.link_changes[:, 0]) > MOST_LINK_CHANGE):
        return False
    return _helps(model, model.nuisance.of_links)


def _helps(model: Model, place: slice) -> bool:
    # Whether letting go of stated values lowers the error on motion not fitted, beyond chance.
    without = model.system.normal.without(list(range(place.start, place.stop)))
    gain = (without.heldout_errors(model.gap.blocks.folds) - model.heldout_errors).sum(axis=0)
    return bool(np.mean(gain) > BAR * np.std(gain, ddof=1) / np.sqrt(gain.size))


def _usually_off(change: dict[int, float], joint: int) -> float:
    # By how much the other joints' friction is off, as a rule; a few percent where too few can say.
    others = [value for other, value in change.items() if other != joint]
    return typical(others) if len(others) >= FEWEST_OTHERS else LEAST_CHANGE


def _bar(change: dict[int, float], joint: int) -> float:
    if len(change) - 1 < FEWEST_OTHERS:
        return LEAST_CHANGE_ROUGH
    usual = _usually_off(change, joint)
    return LEAST_CHANGE if usual < EXACT else min(ALWAYS, max(LEAST_CHANGE_ROUGH, OUTLYING * usual))
