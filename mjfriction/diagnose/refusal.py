"""Causes that fit and are none: what a model that was found is asked before it is believed."""

from __future__ import annotations

import numpy as np

from mjfriction.diagnose.causes.delay import JointDelay, late
from mjfriction.diagnose.causes.friction_spot import FrictionSpot
from mjfriction.diagnose.causes.play import Play
from mjfriction.diagnose.causes.presliding import Presliding
from mjfriction.diagnose.causes.varying import Varying
from mjfriction.diagnose.causes.waves import PositionFriction
from mjfriction.diagnose.intervals import half_widths
from mjfriction.diagnose.model import Chosen, Model, cause_block
from mjfriction.diagnose.nearness import nearness_of, relief
from mjfriction.identify.proof import measure_gain
from mjfriction.record.motion_frequency import quickest_motion
from mjfriction.robot.bandwidth import HARMONICS

BENDING = frozenset({"friction.viscous_nonlinear", "friction.stribeck", "friction.presliding", "friction.asymmetry"})
PROOF_SEED = 0  # of the resampling by which a gain is held against zero
ON_THE_WAY = 0.5  # of what friction that builds up over travel gains, that it must gain while its joint moves
APART, SURELY_APART = 0.5, 2.0  # of a delay, and deviations, by which friction's part of it differs from the rest's
EARLY = 0.03  # s, by which one joint's effort comes early behind the slowest filter of its position
BLURRED = 0.1  # of a period of the position filter's cutoff, within which it is not known when a joint turns


def refused(model: Model) -> list[Chosen]:
    """Return the causes of a model that are no findings.

    Those whose gain on motion not fitted may be none while joints move; those whose size is not told from none
    beside another curve on their joint; efforts that seem early beside play; delays of which only a part of the effort
    knows, its friction or what is quicker than the motion; courses of friction over time that raise it when slow and
    lower it when fast, or the other way round; and a spot along a stroke beside waves of friction.
    """
    unproved = [choice for choice in model.chosen if not proved(model, choice)]
    rules = (_dissolved, _of_landings, _torn, _too_quick, _both_ways, _among_waves)
    return [*unproved, *(choice for rule in rules for choice in rule(model))]


def proved(model: Model, choice: Chosen) -> bool:
    """Return whether a cause of a model gains on motion not fitted while joints move, or brings drives and links that
    did as well without it nearer to what is stated than so many numbers more are worth.

    A joint at rest holds its friction at any level below Coulomb's, for as long as it rests: many rows that say one
    thing.  What is seen there alone, and not while the joint moves, is no finding.  Rows count by how sure they
    are.  Friction that builds up over travel does so on the way: most of its gain has to be there.
    """
    gap, weight = model.gap, model.system.rows.weight
    without = model.without(choice)
    price = len(choice.cause.quantities(gap, choice.site)) * float(np.log(gap.blocks.count))
    # By what is usual of robots, too: links that are right to a hundredth are no nearer for being so to a thousandth.
    if min(relief(model, without), nearness_of(without).distance - nearness_of(model).distance) > price:
        return True
    before, after = without.heldout_residual() * weight, model.heldout_residual() * weight
    moving = np.abs(gap.at_rows("velocity")) > gap.doubt_speed
    touched, _ = cause_block(gap, choice)
    if choice.cause.name == Presliding.name:
        joint = choice.site.joint
        gain = np.square(before[:, joint]) - np.square(after[:, joint])
        if np.sum(gain[moving[:, joint]]) < ON_THE_WAY * np.sum(gain):
            return False
    return any(
        measure_gain(before[own, joint], after[own, joint], gap.blocks.row[own], PROOF_SEED).low > 0.0
        for joint, own in ((joint, moving[:, joint]) for joint in touched)
        if np.any(own)
    )


def _dissolved(model: Model) -> list[Chosen]:
    # Two curves over speed on one joint may stand in for a third, each large only to cancel the other: with the shapes
    # let go, the size of one of them is then not even told from none.
    joints = [choice.site.joint for choice in model.chosen if choice.cause.name in BENDING]
    if len(set(joints)) == len(joints):
        return []
    widths = half_widths(model).causes
    doubt = [
        (float(half[0] / max(abs(model.strengths[place][0]), 1e-300)), choice)
        for choice, place, half in zip(model.chosen, model.places, widths, strict=True)
        if choice.cause.name in BENDING and joints.count(choice.site.joint) > 1
    ]
    worst, least_sure = max(doubt, key=lambda entry: entry[0])
    return [least_sure] if worst > 1.0 else []


def _of_landings(model: Model) -> list[Chosen]:
    # With what it lands, a link pushes its motor back before any row can say so: beside play, efforts that seem to come
    # early on the same joint are that.
    loose = {choice.site.joint for choice in model.chosen if isinstance(choice.cause, Play)}
    return [
        choice
        for choice, place in zip(model.chosen, model.places, strict=True)
        if isinstance(choice.cause, JointDelay) and choice.site.joint in loose and model.strengths[place][0] < 0.0
    ]


def _among_waves(model: Model) -> list[Chosen]:
    # A spot and waves spell nearly anything along a stroke: waves by themselves, which fewer do, come before that.
    waving = {choice.site.joint for choice in model.chosen if isinstance(choice.cause, PositionFriction)}
    return [choice for choice in model.chosen if isinstance(choice.cause, FrictionSpot) and choice.site.joint in waving]


def _both_ways(model: Model) -> list[Chosen]:
    return [
        choice
        for choice, place in zip(model.chosen, model.places, strict=True)
        if isinstance(choice.cause, Varying)
        and not choice.cause.one_way(model.gap, choice.site, model.strengths[place])
    ]


def _torn(model: Model) -> list[Chosen]:
    # A drive that reports late reports all of its effort late.  Where friction tells of quite another delay than the
    # rest of the effort does, something else is wrong with one of the two; but friction that comes later still than a
    # rest that is late is that of a contact which yields, and earlier still than an early one, that of a joint which
    # its drive winds up before it turns.  One that is earlier than a filter of positions makes it is a shift only where
    # its friction is known to be as early.
    gap, friction = model.gap, model.gap.known.effort.friction
    out = []
    for choice, place in _delays(model):
        delay = float(model.strengths[place][0])
        joints = gap.examined if choice.cause.whole_arm else (choice.site.joint,)
        own = {joint: gap.reported(joint, late(gap, friction[:, joint], delay)[:, None]) for joint in joints}
        normal = model.system.extended(own, np.zeros(1))
        rest, beside = float(normal.fitted[place][0]), float(normal.fitted[-1])
        deviation = float(np.sqrt(normal.covariance(np.arange(gap.blocks.count))[-1, -1]))
        farther = rest * delay > APART * delay**2 and beside * delay > 0.0
        known = max(APART * abs(delay), SURELY_APART * deviation, BLURRED / gap.motion.cutoff)
        torn = abs(beside) > known and not farther
        early = not choice.cause.whole_arm and delay < -EARLY
        if torn or (early and abs(beside) + SURELY_APART * deviation > APART * abs(delay)):
            out.append(choice)
    return out


def _too_quick(model: Model) -> list[Chosen]:
    # A drive that reports late does so of the motion that its joint was sent on, too.  What is quicker, a controller's
    # answer to its sensor's noise or an arm that shakes its base, may look late by any time: where means over a part of
    # the motion's own period know nothing of it, it is that.
    gap, motion, delays = model.gap, model.gap.motion, _delays(model)
    if not delays:
        return []
    quickest = quickest_motion(motion.position, motion.pieces, motion.rate, gap.body.sliding)
    step = float(np.median(np.diff(gap.chain.time)))
    if quickest == 0.0 or (count := int(0.5 / (HARMONICS * quickest * step))) < 2:
        return []
    normal = model.system.averaged(count)
    covariances = normal.covariance(np.arange(gap.blocks.count)), normal.white_covariance(np.ones(normal.joints))
    out = []
    for choice, place in delays:
        delay, slow = float(model.strengths[place][0]), float(normal.fitted[place][0])
        deviation = np.sqrt(max(float(own[place, place][0, 0]) for own in covariances))
        if slow * delay < APART * delay**2 or abs(slow) < SURELY_APART * deviation:
            out.append(choice)
    return out


def _delays(model: Model) -> list[tuple[Chosen, slice]]:
    # A shift within a sample is refitted along.
    return [
        (choice, place)
        for choice, place in zip(model.chosen, model.places, strict=True)
        if choice.cause.name == JointDelay.name
        and choice.cause.noteworthy(model.gap, choice.site, model.strengths[place])
    ]
