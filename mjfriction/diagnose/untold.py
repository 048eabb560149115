"""Causes of a model that are no findings: they are refitted along, and listed as that."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from mjfriction.diagnose.causes.catalog import STATED_LEVELS
from mjfriction.diagnose.causes.links import LinkCentre, LinkScale
from mjfriction.diagnose.causes.moved_link import MovedLink
from mjfriction.diagnose.causes.presliding import Presliding
from mjfriction.diagnose.causes.torque_constant import TorqueConstant
from mjfriction.diagnose.causes.varying import Step, WarmUpDrift
from mjfriction.diagnose.contacts import more_than_contacts
from mjfriction.diagnose.links_off import links_far_off
from mjfriction.diagnose.model import Chosen, Key, Model, build_model, partners
from mjfriction.diagnose.nearness import STRAINED, relief
from mjfriction.diagnose.stated import Settled
from mjfriction.diagnose.stroke_curve import StrokeCurve, vague_waves
from mjfriction.diagnose.trial import effects, negligible
from mjfriction.diagnose.verdict import beside_oscillations
from mjfriction.identify.gap import Gap
from mjfriction.identify.structure import Structure
from mjfriction.record.log import Floats

LEAST_SEEN = 0.1  # of the mean square that is left at a joint, that a cause must take away there
MISFIT = 0.05  # of what other causes take off it, that may be left for it since their form is not quite theirs
SURELY_SEEN = 0.2  # of what is left, that is enough whatever others take: half as large as the noise
BRISTLE_MISFIT = 0.005  # of what a bristle takes off its joint, that no machine's builds up quite like
# Times the mean square that is left unexplained at a joint that it must take away: half of the RMS.  Beside a load that
# swings or a tone, which are known and refitted along, once.
DROWNED = 3.0
COURSES = frozenset({WarmUpDrift.name, Step.name})  # of friction over time
LEAST_OF_COURSES = 0.2  # of the largest on a joint, that another must reach: no warm-up is quite the one fitted


@dataclass(frozen=True)
class Untold:
    """The causes of a model that are no findings (``keys``), the share of what is left unexplained, by joint, and what
    is left without any cause, on motion not fitted (``bare``, rows by joints).
    """

    keys: frozenset[Key]
    left: dict[int, float]
    bare: Floats


def find_untold(
    settled: Settled, remaining: tuple[Structure, ...], curves: Sequence[StrokeCurve], heldout: Floats
) -> Untold:
    """Return which causes of a settled model are no findings.

    What is next to nothing of the effort, or hardly shows beside what is left on motion not fitted (``heldout``, rows
    by joints, without oscillations), nor keeps drives and links near what is stated, may be what larger causes leave
    that are told a little off.  And a course that no cause is, ``remaining``, can be told in part by many, a brake that
    drags as a warm-up; and what only spells out one of ``curves`` tells of nothing else, nor do two waves of friction
    of which the period is hardly known.  A course over time that is small beside another on its joint is what that
    other's form leaves.  A link is none where all links a few percent off, in all of their ten parameters, do as well,
    nor is a torque constant or a rotor a few percent off on a robot that is so throughout, or at a joint that has play
    or gives: what its accelerations are in between is a matter of how that is drawn.  The other half of a cause that is
    told was asked for by name, and is told too.  Friction that builds up within what any contact yields is one at one
    joint or two, as :func:`~mjfriction.diagnose.contacts.more_than_contacts` says.
    """
    model, strengths = settled.model, settled.model.strengths
    gap = model.gap
    spelt = {gap.robot.joints.index(curve.structure.joint) for curve in curves}
    oscillating = {source.joint for source in model.nuisance.sources}
    left = {gap.robot.joints.index(entry.joint): entry.share for entry in remaining}
    left = {joint: share for joint, share in left.items() if joint not in spelt | oscillating}
    beside = beside_oscillations(model, heldout)
    drowning = {joint: DROWNED * share for joint, share in left.items()} | beside
    left |= beside
    exact = settled.exact
    giving = {choice.site.joint for choice in model.chosen if isinstance(choice.cause, MovedLink)}
    common = {
        choice.key
        for choice, place in zip(model.chosen, model.places, strict=True)
        if not choice.cause.noteworthy(gap, choice.site, strengths[place])
        or (choice.cause.usual(gap, choice.site, strengths[place]) and (not exact or choice.site.joint in giving))
    }
    causes = (*model.chosen, *settled.levels)
    without = {choice.key: without_cause(model, choice) for choice in causes}
    before = {key: own.heldout_residual() for key, own in without.items()}
    common -= more_than_contacts(model, before, heldout)
    small = {
        choice.key
        for choice, place in zip(model.chosen, model.places, strict=True)
        if negligible(model, choice, strengths[place], before[choice.key], heldout)
    }
    small |= _beside_larger_courses(model)
    bare = build_model(gap, model.nuisance, ()).heldout_residual()
    for choice in causes:
        # Without it others bend to stand in for it, and what that costs may show at joints that it does not touch.
        built_up = {
            other.site.joint: before[other.key]
            for other in model.chosen
            if other.cause.name == Presliding.name and other.key != choice.key
        }
        if choice.key in common | small or shows(gap, before[choice.key], heldout, drowning, bare, built_up):
            continue
        # Refitted drives and links may stand in for it only by being off as they hardly ever are: or by what bends them
        # where something is left unexplained.
        if choice.site.joint in left or relief(model, without[choice.key]) < STRAINED:
            small.add(choice.key)
    of_links = [choice for choice in model.chosen if isinstance(choice.cause, LinkScale | LinkCentre)]
    if any(choice.key not in common | small for choice in of_links) and not links_far_off(model):
        common |= {choice.key for choice in of_links}
    told = [choice for choice in model.chosen if choice.key not in common | small]
    asked = {choice.key for choice in model.chosen if partners(choice, told)}
    spelling = frozenset(key for curve in curves for key in curve.keys) | vague_waves(model)
    return Untold(frozenset(common | (small - asked)) | spelling, left, bare)


def _beside_larger_courses(model: Model) -> set[Key]:
    # The courses of friction over time that are small beside another on their joint.
    sizes: dict[int, dict[Key, float]] = {}
    for choice, place in zip(model.chosen, model.places, strict=True):
        if choice.cause.name in COURSES:
            joint = choice.site.joint
            own, _ = effects(model, choice, model.strengths[place], joint)
            sizes.setdefault(joint, {})[choice.key] = own
    return {key for own in sizes.values() for key, size in own.items() if size < LEAST_OF_COURSES * max(own.values())}


def without_cause(model: Model, choice: Chosen) -> Model:
    """Return the model as it would be without a cause, with what could stand in for it held as stated."""
    if isinstance(choice.cause, LinkScale):
        return model.without(choice).without_links()  # the links that are refitted along would scale instead
    if choice.cause is STATED_LEVELS:
        return build_model(model.gap, model.nuisance.without_level(choice.site.joint), model.chosen)
    without, joint = model.without(choice), choice.site.joint
    if isinstance(choice.cause, TorqueConstant) and model.nuisance.level_near(joint):
        return build_model(model.gap, model.nuisance.without_level(joint), without.chosen)
    return without


def shows(
    gap: Gap, before: Floats, after: Floats, drowning: Mapping[int, float], bare: Floats, built_up: Mapping[int, Floats]
) -> bool:
    """Return whether a change takes enough off the mean square on motion not fitted, at one joint at least.

    ``before`` and ``after`` (rows, joints) are left without it and with it, ``bare`` without any cause; ``drowning`` is
    how many times ``after`` a change must take where something is left unexplained, by joint; ``built_up`` what is left
    without another cause by which friction builds up over travel, by the joint that has one.
    """
    for joint in gap.examined:
        own, without, none = (gap.rms(course[:, joint], joint) ** 2 for course in (after, before, bare))
        misfit = min(MISFIT * (none - without), SURELY_SEEN * own)
        if joint in built_up:
            misfit = max(misfit, BRISTLE_MISFIT * (gap.rms(built_up[joint][:, joint], joint) ** 2 - own))
        if without - own > max(LEAST_SEEN * own, misfit, drowning.get(joint, 0.0) * own):
            return True
    return False
