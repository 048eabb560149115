"""Causes of a model that are no findings: they are refitted along, and listed as refitted values."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from mjfriction.diagnose.causes.catalog import STATED_LEVELS
from mjfriction.diagnose.causes.links import LinkCentre, LinkMoments, LinkScale
from mjfriction.diagnose.causes.moved_link import MovedLink
from mjfriction.diagnose.causes.presliding import Presliding
from mjfriction.diagnose.causes.torque_constant import TorqueConstant
from mjfriction.diagnose.causes.varying import Step
from mjfriction.diagnose.fit.model import Chosen, Key, Model, build_model, partners
from mjfriction.diagnose.fit.nearness import STRAINED, relief
from mjfriction.diagnose.fit.small_errors import noise_alone, stands_out
from mjfriction.diagnose.fit.trial import LEAST_EFFECT, least_effect, negligible
from mjfriction.diagnose.search.stroke_curve import StrokeCurve, vague_waves
from mjfriction.diagnose.settle.stated import Settled
from mjfriction.diagnose.tell.contacts import more_than_contacts
from mjfriction.diagnose.tell.links_off import links_far_off
from mjfriction.diagnose.tell.verdict import beside_oscillations
from mjfriction.identify.gap import Gap
from mjfriction.identify.structure import Structure
from mjfriction.record.log import Floats

LEAST_SEEN = 0.1  # a cause must reduce the mean square at a joint by this fraction of what is left there
MISFIT = 0.05  # and by this fraction of the other causes' reduction, since their form may not fit exactly
SURELY_SEEN = 0.2  # fraction of what is left that suffices whatever others reduce: an effect half as large as the noise
BRISTLE_MISFIT = 0.005  # the same as MISFIT beside a bristle, for no machine's friction builds up exactly like it
BETWEEN = 0.02  # of a joint's clear rows: a step that is no farther than that from where a joined log begins is there
# A cause must remove this many times the mean square that is left unexplained at its joint, which halves the RMS; only
# once beside a load that swings or a tone, which are known and refitted along.
DROWNED = 3.0


@dataclass(frozen=True)
class Untold:
    """The causes of a model that are no findings (``keys``), the unexplained share of the residual by joint (``left``),
    and the held-out residual without any cause (``bare``, (rows, joints)).
    """

    keys: frozenset[Key]
    left: dict[int, float]
    bare: Floats


def find_untold(
    settled: Settled, remaining: tuple[Structure, ...], curves: Sequence[StrokeCurve], heldout: Floats
) -> Untold:
    """Return which causes of a settled model are no findings.

    A cause may only fit what larger causes leave, if these are fitted slightly wrong.  That is so if its effort is next
    to nothing, or if it hardly shows beside the held-out residual (``heldout``, (rows, joints), without oscillations)
    and does not keep drives and links near what is stated.  Structure that is no cause (``remaining``) may be fitted in
    part by many causes, such as a dragging brake by a warm-up.  Causes that only approximate one of ``curves`` are
    evidence of nothing else; nor are two friction waves whose period is hardly known.  A course over time that is small
    beside another on its joint is a misfit of that other's form.

    A link is no finding if all links, a few percent off in all of their ten parameters, do as well.  Nor is a torque
    constant or a rotor that is a few percent off, if the whole robot is, or if the joint's link is not where its sensor
    says, because of play or compliance: its accelerations then depend on how that is modelled.  Nor is a gear as stiff
    as those of most arms, if the whole robot is off or other small errors show.  Nor is a change that is slight on any
    robot.

    The other half of a cause that is reported was asked for by name, and is reported too.  Friction that builds up
    within the travel that any contact yields can be a finding at one or two joints, as
    :func:`~mjfriction.diagnose.tell.contacts.more_than_contacts` says.
    """
    model, gap = settled.model, settled.model.gap
    spelt = {gap.robot.joints.index(curve.structure.joint) for curve in curves}
    oscillating = {source.joint for source in model.nuisance.sources}
    left = {gap.robot.joints.index(entry.joint): entry.share for entry in remaining}
    left = {joint: share for joint, share in left.items() if joint not in spelt | oscillating}
    beside = beside_oscillations(model, heldout)
    drowning = {joint: DROWNED * share for joint, share in left.items()} | beside
    left |= beside
    common = {
        choice.key
        for choice, fitted in model.fitted_causes
        if not choice.cause.noteworthy(gap, choice.site, fitted)
        or (choice.cause.usual(gap, choice.site, fitted) and not _known_better(settled, choice, heldout))
    }
    causes = (*model.chosen, *settled.levels)
    without = {choice.key: without_cause(model, choice) for choice in causes}
    before = {key: own.heldout_residual() for key, own in without.items()}
    common -= more_than_contacts(model, before, heldout)
    quiet = noise_alone(gap, heldout)
    small = {
        choice.key
        for choice, fitted in model.fitted_causes
        if negligible(model, choice, fitted, before[choice.key], heldout)
        or abs(float(fitted[0])) < choice.cause.least_change(gap, choice.site)
    }
    bare = build_model(gap, model.nuisance, ()).heldout_residual()
    for choice in causes:
        # Without this cause, others adapt to stand in for it, and what that costs may show at joints that it does not
        # touch: all joints are examined.
        built_up = {
            other.site.joint: before[other.key]
            for other in model.chosen
            if other.cause.name == Presliding.name and other.key != choice.key
        }
        if choice.key in common | small:
            continue
        # What changes from one log to the next is no error of the model, however little it changes.
        amid = not _between_logs(gap, choice)
        least = least_effect(model, choice, quiet=quiet)
        cleared = choice.cause.least_cleared
        without_it = before[choice.key]
        if shows(gap, without_it, heldout, drowning, bare, built_up, least=least, cleared=cleared, amid_others=amid):
            continue
        # A cause also counts if drives and links can stand in for it only by being off as far as they hardly ever are.
        # At a joint where something is left unexplained they may be off because of that, and it does not count.  Nor
        # does a form that fits a part of any error.
        if cleared or choice.site.joint in left or relief(model, without[choice.key]) < STRAINED:
            small.add(choice.key)
    of_links = [choice for choice in model.chosen if isinstance(choice.cause, LinkScale | LinkCentre | LinkMoments)]
    if any(choice.key not in common | small for choice in of_links) and not links_far_off(model):
        common |= {choice.key for choice in of_links}
    told = [choice for choice in model.chosen if choice.key not in common | small]
    asked = {choice.key for choice in model.chosen if partners(choice, told)}
    spelling = frozenset(key for curve in curves for key in curve.keys) | vague_waves(model)
    return Untold(frozenset(common | (small - asked)) | spelling, left, bare)


def _known_better(settled: Settled, choice: Chosen, heldout: Floats) -> bool:
    # Whether a robot is stated so exactly that a change counts which is usual elsewhere.  Of a gear that gives as most
    # do, what is left at every joint must also be the sensor's noise: where other small errors show, it is one of them.
    if isinstance(choice.cause, MovedLink):
        return settled.exact and noise_alone(settled.model.gap, heldout)
    moved = {other.site.joint for other in settled.model.chosen if isinstance(other.cause, MovedLink)}
    return settled.exact and choice.site.joint not in moved


def _between_logs(gap: Gap, choice: Chosen) -> bool:
    # Whether a cause is a step where one of several joined logs begins.
    if not isinstance(choice.cause, Step):
        return False
    time, (moment,) = gap.chain.time[gap.clear[:, choice.site.joint]], choice.site.shape
    starts = [begin for _, begin in gap.log.joined[1:]]
    apart = [np.count_nonzero((time > min(begin, moment)) & (time < max(begin, moment))) for begin in starts]
    return any(rows <= BETWEEN * time.size for rows in apart)


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
    gap: Gap,
    before: Floats,
    after: Floats,
    drowning: Mapping[int, float],
    bare: Floats,
    built_up: Mapping[int, Floats],
    *,
    least: float = LEAST_EFFECT,
    cleared: float = 0.0,
    amid_others: bool = True,
) -> bool:
    """Return whether a change reduces the held-out mean square by enough at one joint or more.

    ``before`` and ``after`` (rows, joints) are the residuals without and with it, ``bare`` the residual without any
    cause.  ``drowning`` has, for joints where something is left unexplained, how many times the mean square of
    ``after`` the change must remove.  ``built_up`` has, for joints with another cause by which friction builds up over
    travel, the residual without that cause.  ``least`` is the share of a joint's RMS effort that what is removed must
    make, and ``cleared`` how many times the mean square of ``after`` it must remove in any case.  ``amid_others`` says
    whether it must stand out of the many small errors that a model of a machine has.
    """
    for joint in gap.examined:
        own, without, none = (gap.rms(course[:, joint], joint) ** 2 for course in (after, before, bare))
        misfit = min(MISFIT * (none - without), SURELY_SEEN * own)
        if joint in built_up:
            misfit = max(misfit, BRISTLE_MISFIT * (gap.rms(built_up[joint][:, joint], joint) ** 2 - own))
        size = (least * gap.rms(gap.measured[:, joint], joint)) ** 2
        asked = max(LEAST_SEEN * own, misfit, cleared * own, drowning.get(joint, 0.0) * own, size)
        if without - own > asked and (stands_out(gap, joint, before, after) or not amid_others):
            return True
    return False
