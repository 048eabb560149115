"""Causes that fit but are not real: the checks that a found model must pass before it is believed."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mjfriction.diagnose.causes.asymmetry import Asymmetry
from mjfriction.diagnose.causes.cause import column
from mjfriction.diagnose.causes.coupling import SharedMotion
from mjfriction.diagnose.causes.delay import JointDelay, late
from mjfriction.diagnose.causes.friction_spot import FrictionSpot
from mjfriction.diagnose.causes.load import Load
from mjfriction.diagnose.causes.play import Play
from mjfriction.diagnose.causes.presliding import Presliding
from mjfriction.diagnose.causes.stribeck import Stribeck
from mjfriction.diagnose.causes.varying import Varying
from mjfriction.diagnose.causes.viscous_nonlinear import ViscousNonlinear
from mjfriction.diagnose.causes.waves import PositionFriction
from mjfriction.diagnose.fit.intervals import half_widths
from mjfriction.diagnose.fit.model import Chosen, Model, cause_block
from mjfriction.diagnose.fit.nearness import nearness_of, relief
from mjfriction.identify.proof import measure_gain
from mjfriction.record.load_turns import load_turns
from mjfriction.record.log import Floats
from mjfriction.record.motion_frequency import quickest_motion
from mjfriction.robot.bandwidth import HARMONICS

# Causes that change the curve of friction over speed.
BENDING = frozenset(cause.name for cause in (ViscousNonlinear, Stribeck, Presliding, Asymmetry))
PROOF_SEED = 0  # of the resampling that tests a gain against zero
ON_THE_WAY = 0.5  # share of its gain that friction which builds up over travel must gain while its joint moves
APART, SURELY_APART = 0.5, 2.0  # delays differ if they do so by this share of one, and this many standard deviations
# Share of its gain that play must gain within this time (s) of a turn of the load: a link lands soon after that.
AT_TURNS, SOON = 0.3, 0.3
SHAKEN = 3  # joints that feel the acceleration of another one's drive, from which on something else moves them all
EARLY = 0.03  # s, the most that one joint's effort may seem early because of a slow filter of its position
BLURRED = 0.1  # periods of the position filter's cutoff, to which the moment at which a joint turns is known


def refused(model: Model) -> list[Chosen]:
    """Return the causes of a model that are no findings.

    These are causes whose held-out gain may be zero while joints move; causes whose size cannot be told from zero
    beside another curve on their joint; efforts that seem early beside play; delays that friction does not share with
    the rest of the effort, that one joint's own undoes, or that only what is quicker than the motion shows; courses of
    friction over time that raise it when slow and lower it when fast, or the other way round; a spot along a stroke
    beside waves of friction; accelerations of other joints that three or more feel through their transmissions; and
    friction under load where a reading that bends as it grows explains more.
    """
    unproved = [choice for choice in model.chosen if not proved(model, choice)]
    rules = (_dissolved, _of_landings, _torn, _undone, _too_quick, _both_ways, _among_waves, _shaken, _bent_reading)
    return [*unproved, *(choice for rule in rules for choice in rule(model))]


def proved(model: Model, choice: Chosen) -> bool:
    """Return whether a cause of a model has a held-out gain while joints move, or instead brings drives and links
    nearer to what is stated by more than its own strengths are worth.

    A joint at rest holds its friction at any level below Coulomb's for as long as it rests: many rows that carry one
    piece of information.  What shows only there, and not while the joint moves, is no finding.  Rows are weighted by
    how certain they are.  Friction that builds up over travel does so on the way, so at least half of its gain has to
    come while its joint moves.  A link crosses its play when the load turns, so a part of its gain has to come soon
    before or after that: what comes elsewhere is noise of the position, which makes the load seem to turn.
    """
    gap, weight = model.gap, model.system.rows.weight
    without = model.without(choice)
    price = len(choice.cause.quantities(gap, choice.site)) * float(np.log(gap.blocks.count))
    # It must also count in units of what is usual for robots: links that are right to a percent are not meaningfully
    # nearer if they are right to a tenth of a percent.
    if min(relief(model, without), nearness_of(without).distance - nearness_of(model).distance) > price:
        return True
    before, after = without.heldout_residual() * weight, model.heldout_residual() * weight
    moving = np.abs(gap.at_rows("velocity")) > gap.doubt_speed
    touched, _ = cause_block(gap, choice)
    gain, own = np.square(before) - np.square(after), choice.site.joint
    if choice.cause.name == Presliding.name and not _gained(gain[:, own], moving[:, own], ON_THE_WAY):
        return False
    if isinstance(choice.cause, Play) and not _gained(gain[:, own], _at_turns(model, own), AT_TURNS):
        return False
    return any(
        measure_gain(before[rows, joint], after[rows, joint], gap.blocks.row[rows], PROOF_SEED).low > 0.0
        for joint, rows in ((joint, moving[:, joint]) for joint in touched)
        if np.any(rows)
    )


def _gained(gain: Floats, there: NDArray[np.bool_], share: float) -> bool:
    # Whether at least a share of a gain (rows,) comes at some rows.
    return bool(np.sum(gain[there]) >= share * np.sum(gain))


def _at_turns(model: Model, joint: int) -> NDArray[np.bool_]:
    # The rows that are near a turn of a joint's load, (rows,).
    gap = model.gap
    turns = load_turns(gap.motion, gap.known.effort.load[:, joint])
    return np.interp(gap.chain.time, gap.motion.time, turns.near(SOON)) > 0.0


def _dissolved(model: Model) -> list[Chosen]:
    # Two curves over speed on one joint may stand in for a third, each large only to cancel the other.  With their
    # shapes free as well, the size of one of them cannot then be told from zero.
    joints = [choice.site.joint for choice in model.chosen if choice.cause.name in BENDING]
    if len(set(joints)) == len(joints):
        return []
    widths = half_widths(model).causes
    doubt = [
        (float(half[0] / max(abs(fitted[0]), 1e-300)), choice)
        for (choice, fitted), half in zip(model.fitted_causes, widths, strict=True)
        if choice.cause.name in BENDING and joints.count(choice.site.joint) > 1
    ]
    worst, least_sure = max(doubt, key=lambda entry: entry[0])
    return [least_sure] if worst > 1.0 else []


def _of_landings(model: Model) -> list[Chosen]:
    # A link that lands after crossing play pushes its motor back before any row can show it.  Beside play, efforts that
    # seem early on the same joint come from that.
    loose = {choice.site.joint for choice in model.chosen if isinstance(choice.cause, Play)}
    return [
        choice
        for choice, fitted in model.fitted_causes
        if isinstance(choice.cause, JointDelay) and choice.site.joint in loose and fitted[0] < 0.0
    ]


def _among_waves(model: Model) -> list[Chosen]:
    # A spot and waves together can imitate nearly anything along a stroke.  Waves alone can do so less, so they are
    # preferred.
    waving = {choice.site.joint for choice in model.chosen if isinstance(choice.cause, PositionFriction)}
    return [choice for choice in model.chosen if isinstance(choice.cause, FrictionSpot) and choice.site.joint in waving]


def _shaken(model: Model) -> list[Chosen]:
    # A transmission is shared with a neighbour.  Where joints all over the arm seem to feel others accelerate, it is
    # the whole arm that moves, as on a mounting that is loose.
    felt = [choice for choice in model.chosen if isinstance(choice.cause, SharedMotion)]
    return felt if len({choice.site.joint for choice in felt}) >= SHAKEN else []


def _bent_reading(model: Model) -> list[Chosen]:
    # A motor that saturates gives less for the same current, the more the larger that is.  Where its joint mostly
    # drives its load, friction under load has nearly the same effect.
    gap, out = model.gap, []
    for choice in (one for one in model.chosen if one.cause.name == Load.name):
        joint, without = choice.site.joint, model.without(choice)
        effort = gap.known.effort.total[:, joint]
        bent = {joint: gap.reported(joint, column(effort * np.abs(effort)))}
        fits = without.with_candidate(choice), without.system.extended(bent, np.zeros(1))
        of_load, of_reading = (float(np.sum(own.heldout_errors(gap.blocks.folds))) for own in fits)
        if of_reading < of_load:
            out.append(choice)
    return out


def _both_ways(model: Model) -> list[Chosen]:
    return [
        choice
        for choice, fitted in model.fitted_causes
        if isinstance(choice.cause, Varying) and not choice.cause.one_way(model.gap, choice.site, fitted)
    ]


def _torn(model: Model) -> list[Chosen]:
    # A drive that reports late reports all of its effort late.  If friction shows quite another delay than the rest of
    # the effort, something else is wrong with one of the two.  But friction even later than a late rest is that of a
    # contact that yields, and friction even earlier than an early rest is that of a joint that its drive winds up
    # before it turns.  An effort that is earlier than a position filter can make it seem is a shift in time only if its
    # friction is known to be as early.  Of a whole log, most joints that can tell have to show that: the friction of
    # one that hardly turns knows no time.
    gap, friction = model.gap, model.gap.known.effort.friction
    out = []
    for choice, place in _delays(model):
        delay = float(model.strengths[place][0])
        joints = gap.examined if choice.cause.whole_arm else (choice.site.joint,)
        count = len(joints)
        own = {
            joint: gap.reported(joint, late(gap, friction[:, joint], delay)[:, None]) * np.eye(count)[k]
            for k, joint in enumerate(joints)
        }
        normal = model.system.extended(own, np.zeros(count))
        rest, beside = float(normal.fitted[place][0]), normal.fitted[-count:]
        deviation = np.sqrt(np.diag(normal.covariance(np.arange(gap.blocks.count)))[-count:])
        farther = (rest * delay > APART * delay**2) & (beside * delay > 0.0)
        apart = max(APART * abs(delay), BLURRED / gap.motion.cutoff)
        torn = (np.abs(beside) > np.maximum(SURELY_APART * deviation, apart)) & ~farther
        if not choice.cause.whole_arm and delay < -EARLY:
            torn |= np.abs(beside) + SURELY_APART * deviation > APART * abs(delay)
        shown = np.array([bool(np.any(columns)) for columns in own.values()])
        telling = torn | (shown & (SURELY_APART * deviation < apart))
        if 2 * np.count_nonzero(torn) > np.count_nonzero(telling):
            out.append(choice)
    return out


def _undone(model: Model) -> list[Chosen]:
    # A recorder that is late is late for every joint.  Where one joint's own delay undoes that of the whole log, it is
    # none of the log's.
    delays = [(choice, float(model.strengths[place][0])) for choice, place in _delays(model)]
    own = [delay for choice, delay in delays if not choice.cause.whole_arm]
    return [
        choice
        for choice, delay in delays
        if choice.cause.whole_arm and any(abs(one + delay) < APART * abs(delay) for one in own)
    ]


def _too_quick(model: Model) -> list[Chosen]:
    # A drive that reports late is also late with the motion that its joint was commanded to make.  What is quicker,
    # such as a controller's response to sensor noise or an arm that shakes its base, may look late by any time.  It is
    # that if means over a part of the motion's own period do not show the delay.
    gap, motion, delays = model.gap, model.gap.motion, _delays(model)
    if not delays:
        return []
    quickest = quickest_motion(motion.position, motion.pieces, motion.rate, gap.body.sliding)
    if quickest == 0.0 or (count := int(0.5 / (HARMONICS * quickest * gap.chain.step))) < 2:
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
    # A shift that would be no finding is only refitted along, and not checked.
    return [
        (choice, place)
        for choice, place in zip(model.chosen, model.places, strict=True)
        if choice.cause.name == JointDelay.name
        and choice.cause.noteworthy(model.gap, choice.site, model.strengths[place])
    ]
