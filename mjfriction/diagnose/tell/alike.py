"""Causes that the recorded motion cannot tell apart."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from mjfriction.diagnose.causes.catalog import STATED_LEVELS
from mjfriction.diagnose.causes.cause import Site
from mjfriction.diagnose.causes.links import LinkScale
from mjfriction.diagnose.causes.payload import Payload
from mjfriction.diagnose.causes.torque_constant import TorqueConstant
from mjfriction.diagnose.fit.as_little import AS_GOOD as AS_LITTLE
from mjfriction.diagnose.fit.intervals import half_widths
from mjfriction.diagnose.fit.model import Chosen, Model, build_model, cause_block, partners, same_columns
from mjfriction.diagnose.fit.nearness import nearness_of
from mjfriction.diagnose.fit.tangent import straightened
from mjfriction.diagnose.fit.trial import Trial, try_out
from mjfriction.diagnose.search.exchange import for_place_of, in_place_of
from mjfriction.diagnose.search.field import Entrant, Field, chances_in, in_place_of_levels
from mjfriction.diagnose.search.short_list import NEAR_BEST
from mjfriction.diagnose.settle.load_at_flange import of_last_link
from mjfriction.identify.gap import Gap
from mjfriction.record.log import Floats

UNDECIDED = 0.05  # a rival with a probability above this is named as an alternative to the chosen cause
AS_GOOD = 1.25  # a rival may leave at most this many times the error that the chosen cause leaves
# A wider cause is a rival where its extra columns may reach this fraction of the chosen cause's effort within their
# 95 % intervals.
ROOM = 0.5
# A wider cause's column is extra where more than this fraction of it is outside the span of the narrower cause's
# columns.
SHARED = 1e-6
MOST_CONFIDENT = 0.9  # upper bound on the confidence of a finding: a cause that nobody thought of cannot be tried
EVEN = 0.5  # upper bound on the confidence of either of two causes that nothing tells apart
# Factor on the confidence of a cause that is just large enough to be reported: it may be unevenness after all.
AT_THE_BAR = 0.5


@dataclass(frozen=True)
class Standing:
    """How a chosen cause compares with its rivals.

    ``alternatives`` are the causes it cannot be told from, ``confidence`` is the probability that it is the right name,
    and ``rival`` is the likeliest of the alternatives.
    """

    alternatives: tuple[str, ...]
    confidence: float
    rival: Chosen | None = None


def standing(model: Model, target: Chosen, field: Field) -> Standing:
    """Remove a cause from the model, try all others in its place, and compare them on held-out motion.

    The difference of two held-out squared errors, in units of the noise variance, is twice the logarithm of how much
    likelier the data are under one cause than under the other. Coloured noise carries less information, so the
    difference is divided by the number of rows that carry the information of one (:func:`redundancy`).
    """
    gap, joint = model.gap, target.site.joint
    rest = tuple(choice for choice in model.chosen if choice.key != target.key)
    # Levels kept near the stated values beside a torque constant might explain the effort without it if they were free.
    # Hold them as stated here, so that free levels compete as a rival.
    beside_factor = isinstance(target.cause, TorqueConstant) and model.nuisance.level_near(joint)
    of_levels = target.cause is STATED_LEVELS or beside_factor
    free = model.nuisance.without_level(joint) if of_levels else model.nuisance
    without = build_model(gap, free, rest)
    own = try_out(without, target)
    if own is None:
        # What a large cause leaves when it is removed passes for noise, and rows so weighted may not fit what is
        # physical.
        weight = model.system.rows.weight
        without = replace(without, system=without.system.reweighted(weight, list(gap.examined)))
        own = try_out(without, target)
    if own is None:
        return Standing((), EVEN)
    chances = chances_in(field)
    if partners(target, rest) and not own.passes(chances.among(target.cause)):
        # The other half of a cause was only tried because its partner names it; nothing else competed for its place.
        return Standing((), min(MOST_CONFIDENT, 1.0 - own.chance) * _clearly(own))
    here = tuple(
        entrant
        for entrant in for_place_of(target, field)
        if target.cause.name not in entrant.cause.contains or _has_room(without, target, entrant)
    )
    if target.cause is STATED_LEVELS:
        here += in_place_of_levels(gap, joint)
    repeated = redundancy(model.residual()[:, joint] * model.system.rows.weight[:, joint])
    _, rivals = in_place_of(without, own, here)
    rivals = [rival for rival in rivals if rival.chosen.cause.name != target.cause.name]
    if any(choice.tangent for choice in rest):
        rivals = [_beside_others_anew(model, without, own, rival) for rival in rivals]
    settled = [level.site.joint for level in free.levels]
    if target.cause is not STATED_LEVELS and joint in gap.examined and joint not in settled:
        # The joint's own levels are held as stated here, so free levels are a rival too.
        levels = try_out(without, Chosen(STATED_LEVELS, Site(joint)))
        rivals += [levels] if levels is not None else []
    same = [rival for rival in rivals if same_columns(gap, rival.chosen, target)]
    rivals = [rival for rival in rivals if rival in same or _is_rival(rival, own, chances.among(rival.chosen.cause))]
    if own.chosen.cause.name == LinkScale.name and of_last_link(gap, joint):
        rivals = [one for one in rivals if one.chosen.cause.name != Payload.name] + _at_the_flange(without)
    rivals = sorted(rivals, key=lambda rival: rival.merit)
    odds = {rival.chosen.cause.name: math.exp(min(0.0, -0.5 * _ahead(gap, own, rival) / repeated)) for rival in rivals}
    odds |= {rival.chosen.cause.name: 1.0 for rival in same}
    total = 1.0 + sum(odds.values())
    alternatives = tuple(name for name, likelihood in odds.items() if likelihood / total > UNDECIDED)
    rival = rivals[-1].chosen if alternatives else None
    return Standing(alternatives, min(MOST_CONFIDENT, (1.0 - own.chance) / total) * _clearly(own), rival)


def _beside_others_anew(model: Model, without: Model, own: Trial, rival: Trial) -> Trial:
    # The other curved causes were linearised beside the chosen cause. A curved rival that comes near the chosen cause
    # even so must be compared beside causes that are linearised anew beside the rival.
    if not rival.chosen.cause.curved or not NEAR_BEST * own.merit < rival.merit < own.merit:
        return rival
    there = straightened(without.with_also(rival.chosen))
    weight = model.system.rows.weight
    left, theirs = (
        float(np.sum(np.square(np.nan_to_num(one.heldout_residual()) * weight))) + nearness_of(one).strain
        for one in (model, there)
    )
    return replace(rival, relief=rival.relief + max(0.0, own.gain + left - theirs - rival.gain))


def _at_the_flange(without: Model) -> list[Trial]:
    # Trials of a payload in the place of the last link, of which a payload is a part.
    trials = (try_out(without, Chosen(Payload(), site)) for site in Payload().sites(without.gap))
    return [one for one in trials if one is not None]


def _ahead(gap: Gap, own: Trial, rival: Trial) -> float:
    # How much better a cause is than its rival. Neither the mass distribution of a payload nor the place where a last
    # link is heavier is known, so it means nothing if one of these two leaves slightly less error.
    last = own.chosen.cause.name == LinkScale.name and of_last_link(gap, own.chosen.site.joint)
    if last and rival.chosen.cause.name == Payload.name:
        return max(0.0, own.gain - rival.gain - (AS_LITTLE**2 - 1.0) * _left_beside(own))
    return own.merit - rival.merit


def _left_beside(own: Trial) -> float:
    # The held-out error that a cause leaves at the joints that feel it.
    return float(np.sum(own.error - own.improvement))


def _clearly(own: Trial) -> float:
    # Confidence factor for how far a cause is above the size required to report it: one just above may be a machine's
    # unevenness after all.
    beyond = own.of_friction / own.least_told if own.least_told > 0.0 else math.inf
    return 1.0 - (1.0 - AT_THE_BAR) * math.exp(1.0 - max(beyond, 1.0))


def _has_room(without: Model, target: Chosen, wider: Entrant) -> bool:
    # A cause that contains the chosen one always fits at least as well. It is a rival only where the motion leaves room
    # for its extra columns: e.g. a stiffness that could make up for much of the offset, over a stroke too short to
    # tell.
    other = Chosen(wider.cause, wider.sites[0])
    model = without.with_also(other)
    strengths, half = model.strengths[model.places[-1]], half_widths(model).causes[-1]
    own, columns = (cause_block(without.gap, one)[0][target.site.joint] for one in (target, other))
    beyond = columns - own @ np.linalg.lstsq(own, columns, rcond=None)[0]
    besides = np.linalg.norm(beyond, axis=0) > SHARED * np.linalg.norm(columns, axis=0)
    most = np.linalg.norm(columns, axis=0) * (np.abs(strengths) + half[: strengths.size]) * besides
    strength = without.with_also(target).strengths[-own.shape[1] :]
    return bool(np.max(most) > ROOM * np.linalg.norm(own @ strength))


def redundancy(weighted: Floats) -> float:
    """Return how many rows carry the information of one: 1 + 2·Σρ_k over the leading positive autocorrelations."""
    rows = weighted.size
    spectrum = np.square(np.abs(np.fft.rfft(weighted - np.mean(weighted), 2 * rows)))
    correlation = np.fft.irfft(spectrum)[: rows // 4]
    correlation /= max(float(correlation[0]), 1e-300)
    leading = int(np.argmax(correlation < 0.05)) or correlation.size
    return 1.0 + 2.0 * float(np.sum(correlation[1:leading]))


def _is_rival(rival: Trial, own: Trial, number: float) -> bool:
    # A cause that would not pass in the place of the chosen one is no explanation, however little the chosen one
    # explains. The error that one leaves in excess of the other is the difference of their gains, whichever joints each
    # touches.
    return rival.passes(number) and own.gain - rival.gain < (AS_GOOD - 1.0) * _left_beside(own)
