"""A whole diagnosis: a log and a robot in; findings, the extended robot and the proof out."""

from __future__ import annotations

import enum
from dataclasses import dataclass

import numpy as np

from mjfriction.diagnose.alike import MOST_CONFIDENT, standing
from mjfriction.diagnose.audit import Fault, find_faults
from mjfriction.diagnose.causes.catalog import STRUCTURAL
from mjfriction.diagnose.compete import Field, compete, make_field
from mjfriction.diagnose.extend import Adjustment, adjustments, extend_robot
from mjfriction.diagnose.gap import Gap, measure_gap
from mjfriction.diagnose.intervals import half_widths
from mjfriction.diagnose.model import Chosen, Model, build_model
from mjfriction.diagnose.nuisance import Nuisance, make_nuisance
from mjfriction.diagnose.proof import Gain, measure_gain
from mjfriction.diagnose.stated import Settled, link_changes, settle, without_links
from mjfriction.diagnose.structure import Structure, find_structure
from mjfriction.record.log import Floats, Log
from mjfriction.robot.effort import reported_unit
from mjfriction.robot.robot import Robot

STRUCTURED = 0.1  # share of what is left that a smooth curve may predict before it counts as unexplained
LEAST_EFFORT = 0.01  # of a joint's RMS effort that unexplained structure must reach
LINK_FINDING = 0.10  # of a link's stated mass and inertia
MUCH_LEFT = 0.1  # of a joint's effort; more than that left, and far above the noise, is never agreement
FAR_ABOVE_NOISE = 5.0  # times the sensor's noise
REFITTED = 0.8  # of an error that is left when refitted values are worth a word
OUTWEIGHED = 0.5  # of what was explained that unexplained structure must reach


class Verdict(enum.Enum):
    """What a diagnosis comes to; the value is its name in a report."""

    EXPLAINED = "explained"
    CONSISTENT = "consistent"
    AMBIGUOUS = "ambiguous"
    UNEXPLAINED = "unexplained"
    BAD_DATA = "bad_data"


@dataclass(frozen=True)
class Fitted:
    """A fitted quantity with its unit and 95 % interval."""

    name: str
    meaning: str
    unit: str
    value: float
    low: float
    high: float


@dataclass(frozen=True)
class Finding:
    """A named cause: where (None for the whole arm), how sure, how much, what it gains on motion not fitted, and where
    it shows: ``shown_at`` is the joint to look at.
    """

    cause: str
    joint: str | None
    confidence: float
    alternatives: tuple[str, ...]
    parameters: tuple[Fitted, ...]
    gain: Gain
    evidence: str
    covariate: str
    shown_at: str


@dataclass(frozen=True)
class JointError:
    """RMS error of one joint before and after, fitted and held out, in the unit of what its drive reports."""

    joint: str
    signal: str
    unit: str
    rms_before: float
    rms_after: float
    rms_heldout_before: float
    rms_heldout_after: float
    noise_floor: float


@dataclass(frozen=True)
class Diagnosis:
    """Everything a diagnosis found.  ``residual_after`` and ``heldout`` (rows, joints) are what the extended model
    leaves, fitted to everything and fitted elsewhere; ``remaining`` names structure no cause explains; ``faults`` are
    those of the log itself, found before any physics is blamed: with any, nothing is fitted.
    """

    gap: Gap
    verdict: Verdict
    summary: str
    joints: tuple[JointError, ...]
    findings: tuple[Finding, ...]
    adjustments: tuple[Adjustment, ...]
    structure_before: tuple[Structure, ...]
    structure_after: tuple[Structure, ...]
    remaining: tuple[Structure, ...]
    faults: tuple[Fault, ...]
    not_examined: tuple[str, ...]
    robot: Robot
    residual_after: Floats
    heldout: Floats


def diagnose_log(log: Log, robot: Robot, *, seed: int = 0) -> Diagnosis:
    """Hold a log against a robot and say what the robot gets wrong.

    ``seed`` sets the resampling behind the intervals of the gains.  Raises :class:`~mjfriction.errors.LogError` or
    :class:`~mjfriction.errors.RobotError` when either cannot be used.
    """
    gap = measure_gap(log, robot)
    faults = tuple(find_faults(gap))
    field = make_field(gap, () if faults else STRUCTURAL)
    nuisance = Nuisance((), ()) if faults else make_nuisance(gap)
    settled = settle(compete(gap, nuisance, field), field)
    model = settled.model
    heldout = model.heldout_residual()
    after = tuple(find_structure(gap, heldout))
    findings = _findings(settled, field, heldout, seed)
    joints = tuple(_joint_error(gap, joint, model.residual(), heldout) for joint in gap.examined)
    remaining = tuple(_unexplained(gap, after, heldout))
    verdict = Verdict.BAD_DATA if faults else _verdict(findings, remaining)
    moving = gap.motion.moving
    return Diagnosis(
        gap=gap,
        verdict=verdict,
        summary=_summary(gap, verdict, findings, joints, remaining) if not faults else _faults_in_words(faults),
        joints=joints,
        findings=tuple(findings),
        adjustments=tuple(adjustments(model)),
        structure_before=tuple(find_structure(gap, np.nan_to_num(gap.residual))),
        structure_after=after,
        remaining=remaining,
        faults=faults,
        not_examined=tuple(joint for i, joint in enumerate(gap.robot.joints) if i not in gap.examined or not moving[i]),
        robot=extend_robot(model),
        residual_after=model.residual(),
        heldout=heldout,
    )


def _findings(settled: Settled, field: Field, heldout: Floats, seed: int) -> list[Finding]:
    model = settled.model
    strengths, widths = model.strengths, half_widths(model)
    found = []
    for choice, place, width in zip(model.chosen, model.places, widths.causes, strict=True):
        found.append((choice, model.without(choice), strengths[place], width))
    for choice in settled.levels:
        joint = choice.site.joint
        i = [level.site.joint for level in model.nuisance.levels].index(joint)
        without = build_model(model.gap, model.nuisance.without_level(joint), model.chosen)
        found.append((choice, without, strengths[2 * i : 2 * i + 2], widths.nuisance[2 * i : 2 * i + 2]))
    findings = []
    for choice, without, own, width in found:
        joint = choice.site.joint
        per_reported = abs(float(model.gap.per_reported[joint]))
        clear = model.gap.clear[:, joint]
        before = without.heldout_residual()[clear, joint] / per_reported
        stands = standing(model, choice, field)
        finding = Finding(
            cause=choice.cause.name,
            joint=model.gap.robot.joints[joint],
            confidence=stands.confidence,
            alternatives=stands.alternatives,
            parameters=tuple(_fitted(model.gap, choice, own, width)),
            gain=measure_gain(before, heldout[clear, joint] / per_reported, model.gap.blocks.row[clear], seed),
            evidence=choice.cause.evidence(model.gap, choice.site, own),
            covariate=choice.cause.covariate,
            shown_at=model.gap.robot.joints[joint],
        )
        findings.append(finding)
    links = _link_finding(model, widths.nuisance, heldout, seed)
    if links is not None:
        findings.append(links)
    return sorted(findings, key=lambda finding: -finding.gain.reduction)


def _link_finding(model: Model, half: Floats, heldout: Floats, seed: int) -> Finding | None:
    """Return the links' inertias as a finding when some are off by more than a stated inertia ever is."""
    gap = model.gap
    changes = link_changes(model)
    if not changes.size or np.max(np.abs(changes)) < LINK_FINDING:
        return None
    before = without_links(model).heldout_residual()
    gains = {}
    for joint in gap.examined:
        clear, unit = gap.clear[:, joint], abs(float(gap.per_reported[joint]))
        rows = (before[clear, joint] / unit, heldout[clear, joint] / unit, gap.blocks.row[clear])
        gains[joint] = measure_gain(*rows, seed)
    joint = max(gains, key=lambda place: gains[place].reduction)
    first = 2 * len(model.nuisance.levels)
    scales = [
        Fitted(
            f"link_scale.{link.name}",
            "mass and inertia of the link that the joint moves, relative to what is stated",
            "1",
            1.0 + float(change),
            1.0 + float(change - width),
            1.0 + float(change + width),
        )
        for link, change, width in zip(model.nuisance.links, changes, half[first:], strict=True)
        if abs(change) >= LINK_FINDING
    ]
    return Finding(
        cause="body.link_inertia",
        joint=None,
        confidence=MOST_CONFIDENT,
        alternatives=(),
        parameters=tuple(scales),
        gain=gains[joint],
        evidence="masses and inertias of the links do not fit the efforts of all joints at once as they are stated",
        covariate="effort",
        shown_at=gap.robot.joints[joint],
    )


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
            choice.cause.shape_parameters, choice.site.shape, half[len(quantities) :], strict=True
        )
    ]
    return [
        Fitted(
            name=declared.name,
            meaning=declared.meaning,
            unit=declared.unit_for(sliding=sliding),
            value=float(value),
            low=float(max(declared.lower, value - width)),
            high=float(min(declared.upper, value + width)),
        )
        for declared, value, width in entries
    ]


def _joint_error(gap: Gap, joint: int, residual_after: Floats, heldout: Floats) -> JointError:
    unit = abs(float(gap.per_reported[joint]))
    quantity = gap.motion.quantity[joint]
    assert quantity is not None, "examined joints have a measurement"
    before = gap.rms(gap.residual[:, joint], joint) / unit
    return JointError(
        joint=gap.robot.joints[joint],
        signal=quantity,
        unit=reported_unit(quantity, gap.body.sliding[joint]),
        rms_before=before,
        rms_after=gap.rms(residual_after[:, joint], joint) / unit,
        rms_heldout_before=before,
        rms_heldout_after=gap.rms(heldout[:, joint], joint) / unit,
        noise_floor=float(gap.noise_floor[joint]) / unit,
    )


def _unexplained(gap: Gap, after: tuple[Structure, ...], heldout: Floats) -> list[Structure]:
    out = []
    for joint in gap.examined:
        name = gap.robot.joints[joint]
        worst = max((entry for entry in after if entry.joint == name), key=lambda entry: entry.share, default=None)
        left = gap.rms(heldout[:, joint], joint)
        effort = gap.rms(gap.measured[:, joint], joint)
        if left > max(MUCH_LEFT * effort, FAR_ABOVE_NOISE * float(gap.noise_floor[joint])):
            out.append(worst or Structure(name, "time", 0.0))
            continue
        if worst is None or worst.share < STRUCTURED:
            continue
        explained = np.sqrt(max(0.0, gap.rms(gap.residual[:, joint], joint) ** 2 - left**2))
        size = np.sqrt(worst.share) * left
        if size > max(LEAST_EFFORT * effort, OUTWEIGHED * explained):
            out.append(worst)
    return out


def _verdict(findings: list[Finding], remaining: tuple[Structure, ...]) -> Verdict:
    if remaining:
        return Verdict.UNEXPLAINED
    if any(finding.alternatives for finding in findings):
        return Verdict.AMBIGUOUS
    return Verdict.EXPLAINED if findings else Verdict.CONSISTENT


def _summary(
    gap: Gap,
    verdict: Verdict,
    findings: list[Finding],
    joints: tuple[JointError, ...],
    remaining: tuple[Structure, ...],
) -> str:
    robot = gap.robot.name
    named = ", ".join(_named(finding) for finding in findings)
    if verdict is Verdict.CONSISTENT:
        return f"The model of '{robot}' agrees with the log: {_refits(joints)}."
    if findings:
        errors = {error.joint: error for error in joints}
        worst = errors[findings[0].shown_at]
        share = 100.0 * (1.0 - worst.rms_heldout_after / max(worst.rms_heldout_before, 1e-300))
        gain = (
            f"building {'it' if len(findings) == 1 else 'them'} in takes the error of {worst.joint} from "
            f"{worst.rms_heldout_before:.3g} to {worst.rms_heldout_after:.3g} {worst.unit} on motion not fitted "
            f"({share:.0f} % less)"
        )
    if verdict is Verdict.UNEXPLAINED:
        left = ", ".join(_left(entry, joints) for entry in remaining)
        found = f"Found: {named}; {gain}. But" if findings else "No cause that this version knows fits, but"
        return f"{found} an error remains that none explains: {left}."
    if verdict is Verdict.AMBIGUOUS:
        unsure = next(finding for finding in findings if finding.alternatives)
        return (
            f"The model of '{robot}' lacks {named}; {gain}. On this motion {_named(unsure)} cannot be told from "
            f"{' or '.join(unsure.alternatives)}."
        )
    return f"The model of '{robot}' lacks {named}; {gain}."


def _faults_in_words(faults: tuple[Fault, ...]) -> str:
    listed = "; ".join(f"{fault.kind} in {fault.where}: {fault.action}" for fault in faults)
    return f"The log itself is at fault, and nothing was fitted to it: {listed}."


def _named(finding: Finding) -> str:
    return f"{finding.cause} at {finding.joint}" if finding.joint else finding.cause


def _refits(joints: tuple[JointError, ...]) -> str:
    moved = max(joints, key=lambda error: error.rms_heldout_before - error.rms_heldout_after, default=None)
    if moved is None or moved.rms_heldout_after > REFITTED * moved.rms_heldout_before:
        return "nothing beyond the noise was found"
    return (
        "nothing was found beyond stated values that are a little off; refitting those takes the error of "
        f"{moved.joint} from {moved.rms_heldout_before:.3g} to {moved.rms_heldout_after:.3g} {moved.unit}"
    )


def _left(entry: Structure, joints: tuple[JointError, ...]) -> str:
    error = next(error for error in joints if error.joint == entry.joint)
    course = f", of which {100 * entry.share:.0f} % follow {entry.covariate}" if entry.share > STRUCTURED else ""
    return f"{error.rms_heldout_after:.3g} {error.unit} at {entry.joint}{course}"
