"""The findings of a settled model: each cause with its size, its gain and its rivals."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from mjfriction.diagnose.causes.catalog import STATED_LEVELS
from mjfriction.diagnose.causes.cause import Site
from mjfriction.diagnose.causes.links import LinkScale
from mjfriction.diagnose.causes.payload import Payload
from mjfriction.diagnose.causes.torque_constant import TorqueConstant
from mjfriction.diagnose.fit.intervals import widths_told
from mjfriction.diagnose.fit.model import Chosen, Key, Model, build_model
from mjfriction.diagnose.fit.refitted import FEWEST_JOINTS
from mjfriction.diagnose.fit.small_errors import noise_alone
from mjfriction.diagnose.fit.trial import shown_at
from mjfriction.diagnose.search.field import Field
from mjfriction.diagnose.search.fitted_on import fitted_on, untied
from mjfriction.diagnose.settle.one_factor import with_factor
from mjfriction.diagnose.settle.stated import Settled
from mjfriction.diagnose.tell.alike import EVEN, Standing, standing
from mjfriction.diagnose.tell.link_finding import link_finding
from mjfriction.diagnose.tell.outcome import Finding
from mjfriction.diagnose.tell.separate import Experiment, design_experiment, with_rival
from mjfriction.diagnose.tell.to_tell import ToTell, to_tell
from mjfriction.diagnose.tell.untold import Untold
from mjfriction.identify.excerpt import excerpt
from mjfriction.identify.proof import gain_at
from mjfriction.record.log import Floats

OF_ONE_FACTOR = {STATED_LEVELS.name: TorqueConstant.name, TorqueConstant.name: STATED_LEVELS.name}
ONE_OF_MANY = 0.25  # confidence below which a cause with alternatives is one of so many that it names nothing
# Confidence below which a cause with alternatives is no finding on a machine of so many joints, whose efforts together
# tell most causes apart: several small errors add up to what none of them is.  On fewer joints causes are alike by
# nature.
ONE_OF_SEVERAL, SEVERAL_JOINTS = 0.4, 4
# The same of a cause without alternatives where other small errors show: it is hardly larger than those.
HARDLY_LARGER = 0.6
# Confidence below which nothing is reported: a cause's other half may prove to be none once all is known.
FAINTEST = 0.05


@dataclass(frozen=True)
class Told:
    """The ``findings``, largest gain first, and the ``experiment`` (a motion) that would settle the least certain of
    them.

    ``untold`` are the causes of the model that are not findings.
    """

    findings: tuple[Finding, ...]
    experiment: Experiment | None
    untold: frozenset[Key]


def make_findings(settled: Settled, untold: Untold, field: Field, seed: int) -> Told:
    """Return what there is to report of a settled model.

    ``untold`` says which of its causes are not findings. A cause is not a finding either if it is very unlikely, if it
    is one of many alternatives and something is left unexplained or there is another finding at its joint, or if it is
    one of several, or hardly larger than other small errors, on a machine of several joints. ``seed`` sets the
    resampling behind the intervals of the gains.
    """
    model = settled.model
    heldout, widths = model.heldout_residual(oscillations=True), widths_told(model)
    entries, links = list(to_tell(settled, untold, widths)), link_finding(model, widths, untold, field, seed)
    # Of refitted links, whatever is at the end of its usual range is off the most: nothing picked it.
    if links is not None and len(model.gap.examined) >= SEVERAL_JOINTS and links.confidence < EVEN:
        links = None
    links_off = links is not None or any(entry.choice.cause.name == LinkScale.name for entry in entries)
    findings = [] if links is None else [links]
    of_many: set[Key] = set()
    unsure: list[_Unsure] = []
    standings = _standings(settled, entries, field)
    slight = _slight_on(model)
    firm = [
        entry.choice
        for entry, stands in zip(entries, standings, strict=True)
        if not _one_of_many(stands) and not slight(stands)
    ]
    for entry, stands in zip(entries, standings, strict=True):
        choice = entry.choice
        if slight(stands) or (choice not in firm and _names_nothing(choice, stands, untold, firm)):
            of_many.add(choice.key)
            continue
        instead = _instead(settled, choice, stands) if stands.alternatives else None
        unsure += [] if instead is None else [_Unsure(stands.confidence, choice, *instead)]
        bounded = _beside_left(choice, stands, untold)
        findings.append(_finding(model, entry, _beside_links(choice, bounded) if links_off else bounded, heldout, seed))
    findings.sort(key=lambda finding: -finding.gain.reduction)
    return Told(tuple(findings), _settling(model, unsure), untold.keys | of_many)


def _standings(settled: Settled, entries: Sequence[ToTell], field: Field) -> list[Standing]:
    # Of a long log, rivals are tried on the part that was searched.
    part = excerpt(settled.model.gap)
    if part is settled.model.gap:
        return [_standing(settled, entry.choice, field) for entry in entries]
    searched = replace(settled, model=fitted_on(part, settled.model))
    there = {choice.key: choice for choice in searched.model.chosen}
    standings = [_standing(searched, there.get(entry.choice.key, entry.choice), field) for entry in entries]
    return [replace(one, rival=None if one.rival is None else untied(one.rival)) for one in standings]


def _standing(settled: Settled, choice: Chosen, field: Field) -> Standing:
    stands = _beside_replaced(choice, standing(settled.model, choice, field))
    return _of_one_factor(choice, stands) if choice.site.joint in settled.scaled else stands


def _beside_replaced(choice: Chosen, stands: Standing) -> Standing:
    # Causes that leave clearly less than the one that took their place are no worse an explanation.
    others = _replaced(choice)
    if not others:
        return stands
    alternatives = tuple(dict.fromkeys((*stands.alternatives, *others)))
    return replace(stands, alternatives=alternatives, confidence=min(stands.confidence, EVEN))


def _replaced(choice: Chosen) -> list[str]:
    return sorted({other.cause.name for other in choice.instead} - {choice.cause.name})


def _one_of_many(stands: Standing) -> bool:
    return stands.confidence < FAINTEST or (bool(stands.alternatives) and stands.confidence < ONE_OF_MANY)


def _slight_on(model: Model) -> Callable[[Standing], bool]:
    # Whether a standing is too weak for a finding on this machine. Oscillations that are refitted along are known, and
    # no small errors.
    several, quiet = len(model.gap.examined) >= SEVERAL_JOINTS, noise_alone(model.gap, model.heldout_residual())

    def slight(stands: Standing) -> bool:
        least = ONE_OF_SEVERAL if stands.alternatives else 0.0 if quiet else HARDLY_LARGER
        return several and stands.confidence < least

    return slight


def _names_nothing(choice: Chosen, stands: Standing, untold: Untold, firm: Sequence[Chosen]) -> bool:
    # One of many alternatives may be all that is known of a joint. But where an error is left that no cause explains,
    # or that a ``firm`` cause beside it leaves because its form is not quite the fitted one, the cause names a random
    # part of that error.
    if stands.confidence < FAINTEST:
        return True
    if choice.cause.whole_arm:
        return bool(untold.left)
    joint = choice.site.joint
    return joint in untold.left or any(one.site.joint == joint and not one.cause.whole_arm for one in firm)


@dataclass(frozen=True)
class _Unsure:
    confidence: float
    choice: Chosen
    rival: str  # cause name of its likeliest rival
    other: Model  # the model with that rival in its place


def _settling(model: Model, unsure: Sequence[_Unsure]) -> Experiment | None:
    # The motion that best distinguishes the least certain finding from its rival.
    if not unsure:
        return None
    least = min(unsure, key=lambda entry: entry.confidence)
    return design_experiment(model, least.other, least.choice.site.joint, (least.choice.cause.name, least.rival))


def _finding(model: Model, told: ToTell, stands: Standing, heldout: Floats, seed: int) -> Finding:
    choice, gap = told.choice, model.gap
    before = told.without.heldout_residual(oscillations=True)
    shown = shown_at(model, choice, before, heldout)
    return Finding(
        cause=choice.cause.name,
        joint=None if choice.cause.whole_arm else gap.robot.joints[choice.cause.told_at(choice.site)],
        confidence=stands.confidence,
        alternatives=stands.alternatives,
        parameters=told.parameters,
        gain=gain_at(gap, before, heldout, shown, seed),
        evidence=choice.cause.evidence(gap, choice.site, told.strengths),
        covariate=choice.cause.covariate,
        picture=choice.cause.picture,
        shown_at=gap.robot.joints[shown],
        without=heldout[:, shown] + model.made_by(told.places)[:, shown],
    )


def _instead(settled: Settled, choice: Chosen, stands: Standing) -> tuple[str, Model] | None:
    # The likeliest other explanation: the name of its cause, and the whole model.
    model, joint = settled.model, choice.site.joint
    if _replaced(choice):
        rest = tuple(other for other in model.chosen if other.key != choice.key)
        return _replaced(choice)[-1], build_model(model.gap, model.nuisance, (*rest, *choice.instead))
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
    # Both levels off by one factor, and a torque constant off by that factor: either may be the cause.
    if choice.cause.name not in OF_ONE_FACTOR:
        return stands
    alternatives = tuple(dict.fromkeys((*stands.alternatives, OF_ONE_FACTOR[choice.cause.name])))
    return replace(stands, alternatives=alternatives, confidence=min(stands.confidence, EVEN))


def _beside_left(choice: Chosen, stands: Standing, untold: Untold) -> Standing:
    # Where an error is left that no cause explains, what was found may be a part of it that a cause happens to fit.
    # What is left at many joints comes from something that the whole arm feels, and its part may be at any joint.
    if choice.site.joint not in untold.left and len(untold.left) < FEWEST_JOINTS:
        return stands
    return replace(stands, confidence=min(stands.confidence, EVEN))


def _beside_links(choice: Chosen, stands: Standing) -> Standing:
    # A payload that is held throughout is a part of the last link, and that link may be off too where others are.
    if not isinstance(choice.cause, Payload) or stands.alternatives:
        return stands
    return replace(stands, alternatives=(LinkScale.name,), confidence=min(stands.confidence, EVEN))
