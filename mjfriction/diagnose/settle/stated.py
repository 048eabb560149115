"""Which stated values to move, and when a moved friction level is a finding of its own."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from mjfriction.diagnose.causes.along_stroke import FrictionAlongStroke
from mjfriction.diagnose.causes.asymmetry import Asymmetry
from mjfriction.diagnose.causes.catalog import STATED_LEVELS
from mjfriction.diagnose.causes.friction_at_place import FrictionAtPlace
from mjfriction.diagnose.causes.stribeck import Stribeck
from mjfriction.diagnose.causes.waves import PositionFriction
from mjfriction.diagnose.fit.as_little import leaves_as_little
from mjfriction.diagnose.fit.exact import (
    EXACT,
    FEWEST_OTHERS,
    OUTLYING,
    least_off,
    level_changes,
    may_be_off,
    relative_change,
    stated_exactly,
    usually_off,
)
from mjfriction.diagnose.fit.model import Chosen, Model, build_model, cause_block, without_contained
from mjfriction.diagnose.fit.refitted import Level
from mjfriction.diagnose.fit.shapes import reshaped
from mjfriction.diagnose.fit.trial import FALSE_ALARM, Trial, try_out
from mjfriction.diagnose.search.allowed import as_allowed
from mjfriction.diagnose.search.courses import as_courses
from mjfriction.diagnose.search.field import Field, chances_in, in_place_of_levels
from mjfriction.diagnose.search.short_list import contenders, passing
from mjfriction.diagnose.settle.as_plain import as_plain
from mjfriction.diagnose.settle.held_links import held_links
from mjfriction.diagnose.settle.hidden_curve import SUSPECT, with_hidden_curve
from mjfriction.diagnose.settle.levels_kept import (
    CURVES,
    WITH_LEVELS,
    drives_besides,
    one_for_both,
    with_levels_as_stated,
)
from mjfriction.diagnose.settle.load_at_flange import as_load
from mjfriction.diagnose.settle.one_factor import beside_factors, one_number, scaled_levels
from mjfriction.robot.friction import stated_levels

MOST_LINK_CHANGE = 0.8  # relative change of a link's scale above which the fit is no link but a sign of something else
LEAST_CHANGE = 0.04  # relative change of friction above which it is a finding on a robot stated exactly
LEAST_CHANGE_ROUGH = 0.10  # the same where all joints are slightly off, or where there are too few to compare
AS_MUCH = 1.0  # relative change of friction from which a curve's parametrisation can no longer explain it
# A bend counts as faded where it contributes less than this fraction of the level change.  That is examined above the
# RMS speed or, for a spot or an edge, where it is below this fraction of its height.
FADED = 0.1
LEFT = 0.1  # least share of a joint's clear rows that must lie there for this to be examined
ALWAYS = 0.25  # relative change of friction above which it is a finding, however far off the other joints are
NEARER_LINKS = (
    0.1,
    0.2,
    0.4,
)  # shares of the usual deviation of links that are tried on a robot that is stated exactly
BAR = 2.0  # standard errors by which refitted zeros, drives or links must improve the held-out error to be kept


@dataclass(frozen=True)
class Settled:
    """The final model, and those of its friction ``levels`` that are findings.

    ``scaled`` has the joints whose levels are both off by about one factor, so that the drive's torque constant may be
    off instead; its values are the relative spread around the stated values that levels then have.  ``exact`` says
    whether everything except the causes found is taken to be as stated.
    """

    model: Model
    levels: tuple[Chosen, ...]
    scaled: Mapping[int, float] = field(default_factory=dict)
    exact: bool = False


def settle(model: Model, asked: Field) -> Settled:
    """Keep the refitted stated values that improve held-out error, and name the friction levels that are findings.

    A level is a finding if it helps beyond chance and by enough to matter, and if its change is large enough: more than
    4 % of the stated friction on a robot stated exactly; where the other joints are slightly off too, more than 10 %
    and three times the typical change, or more than 25 % in any case.  Where friction follows temperature, pressure or
    load, or settles, the change must be that large at every moment of this course.  If another cause does as well with
    fewer degrees of freedom, it takes the level's place and the level is held as stated.  If both levels are off by one
    factor, a torque constant that is off by this factor takes their place.  Levels that are nearly off enough may only
    follow a curve over speed, which then takes their place.

    Refitted links are kept as near to what is stated as does as well if friction is stated exactly, and are held as
    stated if one cause does as well and everything else is stated almost exactly.  A load at
    the flange takes the place of a last link that is off.  Finally, plainer causes take the place of those that contain
    them and leave no less, and curves along strokes that of causes that only approximate them.
    """
    field_size = len(model.nuisance.levels)
    model = one_number(with_levels_as_stated(drives_besides(model)))
    change, off, most = level_changes(model), least_off(model), may_be_off(model)
    model, alike = beside_factors(model, change)
    findings: list[Chosen] = []
    for level in model.nuisance.levels:
        joint = level.site.joint
        if level.near:
            continue
        bar = _bar(change, joint, off)
        if _bent(model, joint) and change[joint] > bar:
            unbent = _unbent(model, joint, asked)
            if unbent is not None:
                model = unbent
                continue
        held, trial = _as_stated(model, level)
        if trial is None or trial.chance > FALSE_ALARM or trial.gain <= 0.0:
            model = held
        elif trial.passes(field_size) and change[joint] > bar and not _of_another_moment(model, level, bar):
            model, own, spread = _explained(model, level, held, trial, change, bar, asked)
            findings += own
            alike |= spread
        elif trial.passes(field_size) and SUSPECT < change[joint] <= bar:
            model = with_hidden_curve(model, joint, change, asked)
    model = with_levels_as_stated(model)
    if model.nuisance.zeros and not _helps(model, model.nuisance.of_zeros):
        model = model.without_zeros()
    if model.nuisance.drives and not _helps(model, model.nuisance.of_drives):
        model = model.without_drives()
    with_links = _nearer_links(model) if _links_help(model) else model.without_links()
    model = held_links(with_links, asked, off, most)
    one_for_all = model is not with_links
    model = as_load(model, exact=one_for_all or stated_exactly(model))
    # Holding levels changes the residual, and with it which causes only approximate a curve along a stroke.
    model = as_courses(as_plain(as_allowed(model, asked), asked))
    findings = [level for level in findings if not _rising(model, level.site.joint)]
    return Settled(model, tuple(findings), alike, exact=one_for_all or stated_exactly(model))


def _bent(model: Model, joint: int) -> bool:
    # Whether a cause bends the friction curve over speed, or lets the level vary along a stroke of which the motion
    # covers only a part.  What remains for level and damping then depends on the basis functions of that cause.
    return any(
        choice.site.joint == joint
        and choice.cause.name in WITH_LEVELS
        and choice.cause.noteworthy(model.gap, choice.site, fitted)
        for choice, fitted in model.fitted_causes
    )


def _unbent(model: Model, joint: int, asked: Field) -> Model | None:
    # Level and damping that are off, together with a bend, may be a single curve whose end the motion does not reach.
    # If that curve leaves as little, it is the simpler explanation.
    bends = [choice for choice in model.chosen if choice.site.joint == joint and choice.cause.name in CURVES]
    rest = tuple(choice for choice in model.chosen if choice not in bends)
    held = build_model(model.gap, model.nuisance.without_level(joint), rest)
    trials = contenders(held, in_place_of_levels(model.gap, joint, bent=True)) if bends else []
    for trial in passing(trials, chances_in(asked)):
        if leaves_as_little(held.with_also(trial.chosen), model, [joint]):
            return build_model(held.gap, held.nuisance, (*rest, trial.chosen))
    return None


def _explained(
    model: Model, level: Level, held: Model, free: Trial, change: dict[int, float], bar: float, asked: Field
) -> tuple[Model, list[Chosen], dict[int, float]]:
    # The model with one cause in place of a joint's levels that are far off, if one does as well; otherwise these
    # levels, tried as ``free`` ones beside those that are ``held``, are the finding.  Last, by joint, the spread of
    # levels elsewhere where the torque constant may be off instead.
    joint, rival = level.site.joint, _simpler(held, free, asked, bar)
    if rival is not None:
        return build_model(held.gap, held.nuisance, (*without_contained(held.chosen, rival), rival)), [], {}
    scaled = scaled_levels(model, held, free, change)
    spread = {} if scaled is None else {joint: scaled.spread}
    if scaled is not None and scaled.one_factor:
        return scaled.model, [], spread
    other = one_for_both(model, joint, asked)
    if other is not None:
        return other, [], spread
    return model, [free.chosen] if _own(model, level, change[joint], bar) else [], spread


def _own(model: Model, level: Level, change: float, bar: float) -> bool:
    # Whether levels are off in their own right: not as part of the basis of a bend, not as the base of friction that
    # rises or falls from one end of the stroke to the other, and not in one direction only.
    joint = level.site.joint
    bent = _bent(model, joint) and change < AS_MUCH and not _off_beyond_a_bend(model, level, bar)
    return not bent and not _rising(model, joint) and not _of_one_direction(model, level, bar)


def _of_one_direction(model: Model, level: Level, bar: float) -> bool:
    # Where friction differs between the directions and is as stated in one of them, only the other direction is off.
    gap, joint = model.gap, level.site.joint
    change = model.strengths[model.nuisance.of_level(joint)]
    differing = [
        float(fitted[0])
        for choice, fitted in model.fitted_causes
        if isinstance(choice.cause, Asymmetry) and choice.site.joint == joint
    ]
    ways = [change + np.array([0.0, way * half]) for half in differing for way in (-1.0, 1.0)]
    return any(relative_change(gap, level.site, way) <= bar for way in ways)


def _rising(model: Model, joint: int) -> bool:
    stroke = float(np.ptp(model.gap.motion.position[:, joint]))
    return any(
        isinstance(choice.cause, FrictionAlongStroke)
        or (isinstance(choice.cause, PositionFriction) and 2.0 * np.pi / choice.site.shape[0] > stroke)
        for choice in model.chosen
        if choice.site.joint == joint
    )


def _off_beyond_a_bend(model: Model, level: Level, bar: float) -> bool:
    # Whether friction is off by more than the bar at rows where bends have faded: where the joint is too fast for a
    # bend near rest, or too far away from a spot or an edge.
    gap, joint = model.gap, level.site.joint
    bends = [
        (choice, fitted)
        for choice, fitted in model.fitted_causes
        if choice.site.joint == joint and choice.cause.name in WITH_LEVELS
    ]
    if not all(choice.cause.name == Stribeck.name or isinstance(choice.cause, FrictionAtPlace) for choice, _ in bends):
        return False
    beyond = gap.clear[:, joint].copy()
    for choice, _ in bends:
        if isinstance(choice.cause, FrictionAtPlace):
            column = np.abs(cause_block(gap, choice)[0][joint][:, 0])
            beyond &= column < FADED * np.max(column)
        else:
            speed = np.abs(gap.at_rows("velocity")[:, joint])
            beyond &= speed > gap.rms(speed, joint)
    if not bends or np.count_nonzero(beyond) < LEFT * np.count_nonzero(gap.clear[:, joint]):
        return False
    stated = level.columns[joint] @ np.array(stated_levels(gap.robot.table.joint[joint]))
    moved = level.columns[joint] @ model.strengths[model.nuisance.of_level(joint)]
    bent = sum(cause_block(gap, choice)[0][joint] @ fitted for choice, fitted in bends)
    friction, off, faded = (float(np.linalg.norm(np.asarray(part)[beyond])) for part in (stated, moved, bent))
    return faded < FADED * off and off > bar * friction


def _of_another_moment(model: Model, level: Level, bar: float) -> bool:
    # Whether friction that follows temperature, settles, steps, or grows with pressure or load is as stated at some
    # moment or load.  To which of them the stated values belong, warm or cold, is not an error.
    gap, joint = model.gap, level.site.joint
    change = model.strengths[model.nuisance.of_level(joint)]
    return any(
        relative_change(gap, level.site, change + shift) <= bar
        for choice, fitted in model.fitted_causes
        if choice.site.joint == joint
        for shift in choice.cause.level_shifts(gap, choice.site, fitted)
    )


def _as_stated(model: Model, level: Level) -> tuple[Model, Trial | None]:
    # The model with a level as stated, and the free level tried against it.  Shapes of other causes move to compensate,
    # e.g. a step moves to the beginning of the log.  If a free level does worse beside the moved shapes than beside the
    # previous ones, it is tried beside the previous ones.
    joint, free = level.site.joint, Chosen(STATED_LEVELS, level.site)
    there = build_model(model.gap, model.nuisance.without_level(joint), model.chosen)
    held = reshaped(there, {joint})
    trial = try_out(held, free)
    if held is there or (trial is not None and leaves_as_little(held.with_also(free), model, [joint])):
        return held, trial
    beside = try_out(there, free)
    return (held, trial) if beside is None else (there, beside)


def _simpler(held: Model, own: Trial, asked: Field, bar: float) -> Chosen | None:
    # One cause in place of a joint's levels, which are tried as ``own``.
    joint = own.chosen.site.joint
    # Where the joint has a coupling already, a further one is not a simpler explanation.
    coupled = [one for one in held.chosen if one.site.other is not None]
    there = {one.cause.name for one in coupled if joint in (one.site.joint, one.site.other)}
    here = tuple(entrant for entrant in asked if entrant.joint == joint and entrant.cause.name not in there)
    here += in_place_of_levels(held.gap, joint)
    rivals = [one for one in passing(contenders(held, here), chances_in(asked)) if one.merit > own.merit]
    best = max(rivals, key=lambda trial: trial.merit, default=None)
    if best is None:
        return None
    # Compared at the joint whose levels are in question: to reduce other joints' errors is no reason to leave its own.
    instead, levels = held.with_also(best.chosen), held.with_also(own.chosen)
    as_good = leaves_as_little(instead, levels, [joint])
    return best.chosen if as_good and not _put_off(instead, levels, bar) else None


def _put_off(model: Model, other: Model, bar: float) -> bool:
    # Whether friction has to be off at a joint where it is not in the other model, as at the second joint of a drive
    # that would turn with two: its levels then only undo what they feel of that.
    before = level_changes(other)
    return any(change > max(bar, before.get(joint, 0.0)) for joint, change in level_changes(model).items())


def _links_help(model: Model) -> bool:
    if model.nuisance.inertias is not None:
        return _helps(model, model.nuisance.of_inertias)
    if not model.nuisance.links or np.any(np.abs(model.link_changes[:, 0]) > MOST_LINK_CHANGE):
        return False
    return _helps(model, model.nuisance.of_links)


def _nearer_links(model: Model) -> Model:
    # On a robot that is stated exactly, links are no more off than it takes.  Where the motion hardly shows a link, as
    # at a joint that is held, a prior of some percent leaves it free to make up for noise.
    if not model.nuisance.links or not stated_exactly(model):
        return model
    for share in NEARER_LINKS:
        near = build_model(model.gap, model.nuisance.with_links_nearer(share), model.chosen)
        if leaves_as_little(near, model):
            return near
    return model


def _helps(model: Model, place: slice) -> bool:
    # Whether refitting the stated values at ``place`` lowers the held-out error beyond chance.  Without them the other
    # refitted values may compensate, but only within their usual reach.
    nuisance, normal, bounded = model.nuisance, model.system.normal, model.nuisance.of_bounded
    known = np.concatenate([nuisance.precision, normal.precision[nuisance.count :]])
    without = replace(normal, precision=known).without(list(range(place.start, place.stop)))
    reach = np.delete(nuisance.reach, [i - bounded.start for i in range(place.start, min(place.stop, bounded.stop))])
    without = without.kept_within(slice(bounded.start, bounded.start + reach.size), reach)
    gain = (without.heldout_errors(model.gap.blocks.folds) - model.heldout_errors).sum(axis=0)
    return bool(np.mean(gain) > BAR * np.std(gain, ddof=1) / np.sqrt(gain.size))


def _bar(change: Mapping[int, float], joint: int, off: Mapping[int, float]) -> float:
    # The relative change of friction above which a level is a finding; ``off`` is by how much each joint's friction is
    # off, noise subtracted.
    if len(change) - 1 < FEWEST_OTHERS:
        return LEAST_CHANGE_ROUGH
    if usually_off(off, joint) < EXACT:
        return LEAST_CHANGE
    return min(ALWAYS, max(LEAST_CHANGE_ROUGH, OUTLYING * usually_off(change, joint, at_least=True)))
