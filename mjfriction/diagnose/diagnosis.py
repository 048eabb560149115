"""A whole diagnosis: a log and a robot in; findings, the extended robot and the proof out."""

from __future__ import annotations

import enum
from dataclasses import dataclass

import numpy as np

from mjfriction.diagnose.alike import standing
from mjfriction.diagnose.causes.catalog import STRUCTURAL
from mjfriction.diagnose.compete import Field, compete, make_field
from mjfriction.diagnose.extend import Adjustment, adjustments, extend_robot
from mjfriction.diagnose.gap import Gap, measure_gap
from mjfriction.diagnose.intervals import half_widths
from mjfriction.diagnose.model import Chosen, build_model
from mjfriction.diagnose.nuisance import make_nuisance
from mjfriction.diagnose.proof import Gain, measure_gain
from mjfriction.diagnose.stated import Settled, settle
from mjfriction.diagnose.structure import Structure, find_structure
from mjfriction.record.log import Floats, Log
from mjfriction.robot.effort import reported_unit
from mjfriction.robot.robot import Robot

STRUCTURED = 0.1  # share of what is left that a smooth curve may predict before it counts as unexplained
LEAST_EFFORT = 0.01  # of a joint's RMS effort that unexplained structure must reach
OUTWEIGHED = 0.5  # of what was explained that unexplained structure must reach


class Verdict(enum.Enum):
    """What a diagnosis comes to; the value is its name in a report."""

    EXPLAINED = "explained"
    CONSISTENT = "consistent"
    AMBIGUOUS = "ambiguous"
    UNEXPLAINED = "unexplained"


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
    """A named cause: where, how sure, how much, what it gains on motion not fitted, and where it shows."""

    cause: str
    joint: str
    confidence: float
    alternatives: tuple[str, ...]
    parameters: tuple[Fitted, ...]
    gain: Gain
    evidence: str
    covariate: str


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
    leaves, fitted to everything and fitted elsewhere; ``remaining`` names structure no cause explains.
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
    not_examined: tuple[str, ...]
    robot: Robot
    residual_after: Floats
    heldout: Floats


def diagnose(log: Log, robot: Robot, *, seed: int = 0) -> Diagnosis:
    """Hold a log against a robot and say what the robot gets wrong.

    ``seed`` sets the resampling behind the intervals of the gains.  Raises :class:`~mjfriction.errors.LogError` or
    :class:`~mjfriction.errors.RobotError` when either cannot be used.
    """
    gap = measure_gap(log, robot)
    field = make_field(gap, STRUCTURAL)
    settled = settle(compete(gap, make_nuisance(gap), field), field)
    model = settled.model
    heldout = model.heldout_residual()
    after = tuple(find_structure(gap, heldout))
    findings = _findings(settled, field, heldout, seed)
    joints = tuple(_joint_error(gap, joint, model.residual(), heldout) for joint in gap.examined)
    remaining = tuple(_unexplained(gap, after, heldout))
    verdict = _verdict(findings, remaining)
    moving = gap.motion.moving
    return Diagnosis(
        gap=gap,
        verdict=verdict,
        summary=_summary(gap, verdict, findings, joints, remaining),
        joints=joints,
        findings=tuple(findings),
        adjustments=tuple(adjustments(model)),
        structure_before=tuple(find_structure(gap, np.nan_to_num(gap.residual))),
        structure_after=after,
        remaining=remaining,
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
        )
        findings.append(finding)
    return sorted(findings, key=lambda finding: -finding.gain.reduction)


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
        if worst is None or worst.share < STRUCTURED:
            continue
        left = gap.rms(heldout[:, joint], joint)
        explained = np.sqrt(max(0.0, gap.rms(gap.residual[:, joint], joint) ** 2 - left**2))
        size = np.sqrt(worst.share) * left
        if size > max(LEAST_EFFORT * gap.rms(gap.measured[:, joint], joint), OUTWEIGHED * explained):
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
    named = ", ".join(f"{finding.cause} at {finding.joint}" for finding in findings)
    if findings:
        errors = {error.joint: error for error in joints}
        worst = errors[findings[0].joint]
        share = 100.0 * (1.0 - worst.rms_heldout_after / max(worst.rms_heldout_before, 1e-300))
        gain = (
            f"building it in takes the error of {worst.joint} from {worst.rms_heldout_before:.3g} to "
            f"{worst.rms_heldout_after:.3g} {worst.unit} on motion it was not fitted to ({share:.0f} % less)"
        )
    if verdict is Verdict.CONSISTENT:
        return f"The model of '{robot}' agrees with the log: nothing beyond the noise was found."
    if verdict is Verdict.UNEXPLAINED:
        left = ", ".join(f"{entry.joint} along {entry.covariate} ({100 * entry.share:.0f} %)" for entry in remaining)
        found = f"Found: {named}; {gain}. But" if findings else "No cause that this version knows fits, but"
        return f"{found} structure remains that none explains: {left} of what is left there."
    if verdict is Verdict.AMBIGUOUS:
        unsure = next(finding for finding in findings if finding.alternatives)
        return (
            f"The model of '{robot}' lacks {named}; {gain}. On this motion {unsure.cause} at {unsure.joint} cannot be "
            f"told from {' or '.join(unsure.alternatives)}."
        )
    return f"The model of '{robot}' lacks {named}; {gain}."
