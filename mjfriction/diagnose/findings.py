"""The findings of a settled model: each cause with its size, its gain and its rivals."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from mjfriction.diagnose.alike import EVEN, Standing, standing
from mjfriction.diagnose.causes.catalog import STATED_LEVELS
from mjfriction.diagnose.causes.cause import Site
from mjfriction.diagnose.causes.links import LinkScale
from mjfriction.diagnose.causes.payload import Payload
from mjfriction.diagnose.causes.torque_constant import TorqueConstant
from mjfriction.diagnose.field import Field
from mjfriction.diagnose.intervals import half_widths
from mjfriction.diagnose.link_finding import link_finding
from mjfriction.diagnose.model import Chosen, Key, Model
from mjfriction.diagnose.one_factor import with_factor
from mjfriction.diagnose.one_transmission import parts_of_drives
from mjfriction.diagnose.outcome import Finding
from mjfriction.diagnose.separate import Experiment, design_experiment, with_rival
from mjfriction.diagnose.stated import Settled
from mjfriction.diagnose.trial import shown_at
from mjfriction.diagnose.untold import Untold, without_cause
from mjfriction.identify.fitted import Fitted
from mjfriction.identify.gap import Gap
from mjfriction.identify.proof import gain_at
from mjfriction.record.log import Floats

OF_ONE_FACTOR = {STATED_LEVELS.name: TorqueConstant.name, TorqueConstant.name: STATED_LEVELS.name}
ONE_OF_MANY = 0.25  # confidence of what is one of so many alternatives that it names nothing
FAINTEST = 0.05  # that is told at all: the other half of a cause may be none once all is known


@dataclass(frozen=True)
class Told:
    """The ``findings``, those that gain most first, the motion that would settle the least certain of them, and which
    causes of the model are none (``untold``).
    """

    findings: tuple[Finding, ...]
    experiment: Experiment | None
    untold: frozenset[Key]


def make_findings(settled: Settled, untold: Untold, field: Field, seed: int) -> Told:
    """Return what there is to tell of a settled model.

    ``untold`` tells which of its causes are no findings; neither is what is but one of many alternatives at a joint
    where something is left unexplained, or hardly likely at all.  ``seed`` sets the resampling behind the intervals of
    the gains.
    """
    model = settled.model
    heldout = model.heldout_residual(oscillations=True)
    strengths, widths = model.built, half_widths(model)
    found = []
    parts = parts_of_drives(choice for choice in model.chosen if choice.key not in untold.keys)
    fitted = {
        choice.key: tuple(_fitted(model.gap, choice, strengths[place], width))
        for choice, place, width in zip(model.chosen, model.places, widths.causes, strict=True)
    }
    for choice, place in zip(model.chosen, model.places, strict=True):
        if choice.key in untold.keys or choice in parts.values():
            continue
        part = parts.get(choice.key)
        without = without_cause(model, choice)
        without, more = (without, ()) if part is None else (without.without(part), fitted[part.key])
        found.append((choice, without, strengths[place], (*fitted[choice.key], *more)))
    for choice in settled.levels:
        if choice.key in untold.keys:
            continue
        level = model.nuisance.of_level(choice.site.joint)
        own = strengths[level]
        told = tuple(_fitted(model.gap, choice, own, widths.nuisance[level]))
        found.append((choice, without_cause(model, choice), own, told))
    findings: list[Finding] = []
    throughout: list[Finding] = []  # payloads, that is, and not in some logs only
    of_many: set[Key] = set()
    unsure: list[tuple[float, Chosen, str, Model]] = []
    for choice, without, own, parameters in found:
        joint = choice.site.joint
        stands = standing(model, choice, field)
        if joint in settled.scaled:
            stands = _of_one_factor(choice, stands)
        names_nothing = stands.alternatives and stands.confidence < ONE_OF_MANY and joint in untold.left
        if names_nothing or stands.confidence < FAINTEST:
            of_many.add(choice.key)
            continue
        before = without.heldout_residual(oscillations=True)
        shown = shown_at(model, choice, before, heldout)
        if stands.alternatives:
            instead = _instead(settled, choice, stands)
            unsure += [(stands.confidence, choice, *instead)] if instead is not None else []
        finding = Finding(
            cause=choice.cause.name,
            joint=None if choice.cause.whole_arm else model.gap.robot.joints[choice.cause.told_at(choice.site)],
            confidence=stands.confidence,
            alternatives=stands.alternatives,
            parameters=parameters,
            gain=gain_at(model.gap, before, heldout, shown, seed),
            evidence=choice.cause.evidence(model.gap, choice.site, own),
            covariate=choice.cause.covariate,
            picture=choice.cause.picture,
            shown_at=model.gap.robot.joints[shown],
        )
        findings.append(finding)
        throughout += [finding] if isinstance(choice.cause, Payload) else []
    links = link_finding(model, widths, untold, field, seed)
    if links is not None:
        findings.append(links)
    findings = [_beside_links(finding, findings) if finding in throughout else finding for finding in findings]
    experiment = None
    if unsure:
        _, choice, rival, other = min(unsure, key=lambda entry: entry[0])
        experiment = design_experiment(model, other, choice.site.joint, (choice.cause.name, rival))
    findings.sort(key=lambda finding: -finding.gain.reduction)
    return Told(tuple(findings), experiment, untold.keys | of_many)


def _instead(settled: Settled, choice: Chosen, stands: Standing) -> tuple[str, Model] | None:
    # The likeliest other explanation: its cause's name, and the whole model.
    model, joint = settled.model, choice.site.joint
    if joint in settled.scaled and choice.cause is STATED_LEVELS:
        return TorqueConstant.name, with_factor(model, joint, settled.scaled[joint])
    if joint in settled.scaled and isinstance(choice.cause, TorqueConstant):
        other = with_rival(model, choice, Chosen(STATED_LEVELS, Site(joint)))
        return None if other is None else (STATED_LEVELS.name, other)
    if stands.rival is None:
        return None
    other = with_rival(model, choice, stands.rival)
    return None if other is None else (stands.rival.cause.name, other)


def _of_one_factor(choice: Chosen, stands: Standing) -> Standing:
    # Of levels that are both off by one factor, and of a drive that is, either may be meant.
    if choice.cause.name not in OF_ONE_FACTOR:
        return stands
    alternatives = tuple(dict.fromkeys((*stands.alternatives, OF_ONE_FACTOR[choice.cause.name])))
    return replace(stands, alternatives=alternatives, confidence=min(stands.confidence, EVEN))


def _beside_links(finding: Finding, findings: list[Finding]) -> Finding:
    # What is held at the flange is a part of the last link: beside links that are off it may be that this one is too.
    off = any(one.cause == LinkScale.name for one in findings)
    if finding.alternatives or not off:
        return finding
    return replace(finding, alternatives=(LinkScale.name,), confidence=min(finding.confidence, EVEN))


def _fitted(gap: Gap, choice: Chosen, strengths: Floats, half: Floats) -> list[Fitted]:
    sliding = gap.body.sliding[choice.site.joint]
    quantities = choice.cause.quantities(gap, choice.site)
    entries = [
        (quantity.parameter, quantity.shift + quantity.factor * value, abs(quantity.factor) * width)
        for quantity, value, width in zip(quantities, strengths, half[: len(quantities)], strict=True)
    ]
    entries += [
        (declared, value, width)
        for declared, value, width in zip(
            choice.cause.shape_parameters, choice.site.shape, half[len(quantities) :], strict=False
        )
    ]
    return [
        Fitted(
            name=declared.name,
            meaning=declared.meaning,
            unit=declared.unit_for(sliding=sliding),
            value=float(np.clip(value, declared.lower, declared.upper)),
            low=float(max(declared.lower, value - width)),
            high=float(min(declared.upper, value + width)),
        )
        for declared, value, width in entries
        if width > 0.0  # what the motion does not show at all has no interval
    ]
