"""The outcome of fitted laws: one more step of everything together, for intervals, held-out errors and remarks."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from scipy.stats import t as student

from mjfriction.identify.background import Background
from mjfriction.identify.checks import notes
from mjfriction.identify.choose import Choice
from mjfriction.identify.colour import COLOURED, NOTHING, coloured_share
from mjfriction.identify.falling import FASTER, still_falls
from mjfriction.identify.fit import LawFit
from mjfriction.identify.fitted import Fitted
from mjfriction.identify.gap import Gap
from mjfriction.identify.joint_error import JointError, joint_error
from mjfriction.identify.map_fit import MapFit
from mjfriction.identify.measure import gap_of
from mjfriction.identify.outcome import Candidate, Identification, JointLaw
from mjfriction.identify.refine import Refined
from mjfriction.identify.regression import Columns, Rows, System
from mjfriction.identify.statics import Passes
from mjfriction.identify.structure import Structure, find_structure
from mjfriction.record.log import Floats
from mjfriction.robot.robot import Robot

STRUCTURED = 0.1  # intervals are not trusted where more than this share of the residual follows a covariate
FAR_ABOVE_NOISE = 3.0  # times the sensor's noise, above which a residual is reported
RISEN = 1.1  # times the stated robot's error, above which an identified robot is reported as worse
# Share of the joint's RMS effort that a residual, or its structure, must also exceed to be reported.
LEAST_EFFORT = 0.005
FREE, PASSES, SIMULATED = "free motion", "forward and backward passes", "simulated motion"


def conclude(
    stated: Gap,
    robot: Robot,
    joints: Sequence[int],
    fits: Sequence[LawFit],
    tried: Sequence[Sequence[Choice]],
    background: Sequence[Background],
    passes: Mapping[int, Passes],
    refined: Refined | None,
    bandwidths: Mapping[str, float],
) -> Identification:
    """Return the outcome of an identification.

    The laws ``fits`` at ``joints``, chosen among those ``tried`` there, are built into ``robot`` with the refitted
    ``background``, and compared with the ``stated`` robot's gap.  ``passes`` are the joints'; ``bandwidths`` (Hz) are
    those of drives that were found to low-pass.
    """
    gap = gap_of(robot, stated)
    system = _taken_together(gap, joints, fits, background)
    step = system.normal.fitted
    covariance = _covariance(system, step, gap)
    quantile = float(student.ppf(0.975, gap.blocks.groups - 1))
    heldout = np.array(gap.residual)
    for fold in gap.blocks.folds:
        rows = fold[gap.blocks.row]
        heldout[rows] = system.residual(system.normal.strengths(~fold))[rows]
    passed = _passed(joints, fits, passes)
    for joint in joints:
        if refined is not None or joint in passed:
            # Values that do not come from these rows are tested on them as they are.
            heldout[:, joint] = gap.residual[:, joint]
    after = find_structure(gap, np.nan_to_num(heldout))
    laws, errors, place = [], [], 0
    begun = refined.begun if refined is not None else fits
    for joint, fit, others, before in zip(joints, fits, tried, begun, strict=True):
        own = slice(place, place + fit.x.size)
        place += fit.x.size
        worst = _worst(gap, joint, after, heldout)
        half, spread = _half_widths(fit, covariance[own, own], quantile, passed.get(joint), before)
        falls = still_falls(fit)
        law = JointLaw(
            joint=gap.robot.joints[joint],
            fit=fit,
            how=_how(fit, passes[joint], taken=joint in passed, refined=refined is not None),
            parameters=tuple(
                _parameters(fit, half, notes(fit, half, spread, falls=falls), bool(gap.body.sliding[joint]))
            ),
            candidates=tuple(_candidate(gap, joint, other) for other in others),
            structure=worst.share,
            follows=worst.covariate,
            trusted=not _counts(gap, joint, worst) and not falls,
            falls=falls,
            passes=passes[joint].points,
            by_slope=passes[joint].by_slope(fit),
            pendulum=passes[joint].pendulum,
        )
        laws.append(law)
        errors.append(joint_error(stated, joint, gap.residual, heldout))
    gram, _ = system.normal.products.whole
    beside: list[Fitted] = []
    for part in background:
        own = slice(place, place + part.precision.size)
        beside += part.fitted(robot, gram[own, own], covariance[own, own], quantile)
        place += part.precision.size
    far = [gap.robot.joints[joint] for joint in joints if _far_above_noise(gap, heldout, joint)]
    return Identification(
        gap=stated,
        robot=robot,
        joints=tuple(errors),
        laws=tuple(laws),
        background=tuple(beside),
        heldout=heldout,
        summary=_summary(robot, errors, laws, far, refined),
        simulated=refined,
        bandwidths=bandwidths,
    )


def _how(fit: LawFit, passes: Passes, *, taken: bool, refined: bool) -> str:
    if refined:
        return SIMULATED
    return PASSES if taken else FREE + passes.why_none(fit)


def _taken_together(
    gap: Gap, joints: Sequence[int], fits: Sequence[LawFit], background: Sequence[Background]
) -> System:
    # One further linear step of everything at once, from the current values: intervals and held-out errors come from
    # it.
    target = np.nan_to_num(gap.residual)
    weight = np.zeros_like(target)
    blocks: list[Columns] = []
    precisions: list[Floats] = []
    for joint, fit in zip(joints, fits, strict=True):
        weight[:, joint] = 1.0 / fit.problem.believed(target[:, joint]).deviation
        blocks.append({joint: fit.slopes})
        precisions.append(fit.precision)
    blocks += [part.columns for part in background]
    precisions += [part.precision for part in background]
    return System(Rows(target, weight, gap.blocks.row), blocks, precisions)


def _covariance(system: System, step: Floats, gap: Gap) -> Floats:
    # For each number, take the larger variance of the two.  Coloured noise makes the white-noise variance too small,
    # and few blocks make the clustered one too small; what no row shows has only its prior.  White noise is taken to be
    # as large as the residual, not as large as the doubt about reversals allows.
    normal, weight = system.normal, system.rows.weight
    left = (system.residual(step) * weight)[weight > 0.0]
    spread = max(float(np.sum(np.square(left))) / max(1, left.size - step.size), 1e-12)
    clustered = normal.covariance(gap.blocks.group)
    white = normal.known_to(spread)
    return np.asarray(clustered + np.diag(np.maximum(0.0, np.diag(white) - np.diag(clustered))))


def _passed(joints: Sequence[int], fits: Sequence[LawFit], passes: Mapping[int, Passes]) -> dict[int, MapFit]:
    pairs = zip(joints, fits, strict=True)
    found = {joint: passes[joint].statics(fit) for joint, fit in pairs}
    return {joint: statics for joint, statics in found.items() if statics is not None}


def _half_widths(
    fit: LawFit, covariance: Floats, quantile: float, statics: MapFit | None, begun: LawFit
) -> tuple[Floats, Floats]:
    # Use the half-widths of the passes where the values come from them.  How far a simulation moved a value is added to
    # its interval.
    turned = fit.coordinates.slopes(fit.x)
    spread = turned @ covariance @ turned.T
    half = quantile * np.sqrt(np.maximum(np.diag(spread), 0.0))
    names = list(fit.told)
    if statics is not None:
        half = np.array([statics.half.get(name, own) for name, own in zip(names, half.tolist(), strict=True)])
    moved = np.abs(np.array(list(fit.told.values())) - np.array(list(begun.told.values())))
    return half + moved, spread


def _parameters(fit: LawFit, half: Floats, said: dict[str, str], sliding: bool) -> list[Fitted]:
    out = []
    for (name, value), width in zip(fit.told.items(), half, strict=True):
        declared = fit.law.parameter(name.partition("[")[0])
        low, high = (float(np.clip(value + s * width, declared.lower, declared.upper)) for s in (-1.0, 1.0))
        unit = declared.unit_for(sliding=sliding and fit.problem.side == "joint")
        out.append(Fitted(name, declared.meaning, unit, value, low, high, said.get(name, "")))
    return out


def _candidate(gap: Gap, joint: int, choice: Choice) -> Candidate:
    error = gap.rms(choice.heldout, joint) / abs(float(gap.per_reported[joint]))
    return Candidate(choice.fit.law.name, choice.parameters, error)


def _worst(gap: Gap, joint: int, after: Sequence[Structure], heldout: Floats) -> Structure:
    # The covariate that the error follows most; where that does not count, but the error is not noise either, none that
    # is known.
    name = gap.robot.joints[joint]
    curve = max((entry for entry in after if entry.joint == name), key=lambda entry: entry.share)
    course = Structure(name, NOTHING, coloured_share(gap, joint, heldout))
    return course if _counts(gap, joint, course) and not _counts(gap, joint, curve) else curve


def _counts(gap: Gap, joint: int, worst: Structure) -> bool:
    size = np.sqrt(max(worst.share, 0.0)) * gap.rms(gap.residual[:, joint], joint)
    least = COLOURED if worst.covariate == NOTHING else STRUCTURED
    return bool(worst.share > least and size > LEAST_EFFORT * gap.rms(gap.measured[:, joint], joint))


def _far_above_noise(gap: Gap, heldout: Floats, joint: int) -> bool:
    left = gap.rms(heldout[:, joint], joint)
    effort = gap.rms(gap.measured[:, joint], joint)
    return left > max(FAR_ABOVE_NOISE * float(gap.noise_floor[joint]), LEAST_EFFORT * effort)


def _summary(
    robot: Robot, errors: Sequence[JointError], laws: Sequence[JointLaw], far: Sequence[str], refined: Refined | None
) -> str:
    counted: dict[str, int] = {}
    for law in laws:
        counted[law.fit.law.name] = counted.get(law.fit.law.name, 0) + 1
    listed = ", ".join(f"{name} at {count} joint{'s' * (count > 1)}" for name, count in counted.items())
    most = max(errors, key=lambda error: error.rms_before / max(error.rms_heldout_after, 1e-300))
    verb = "falls" if most.rms_heldout_after < most.rms_before else "goes"
    text = (
        f"Friction of '{robot.name}' identified: {listed}; the error of {most.joint} {verb} from "
        f"{most.rms_before:.3g} to {most.rms_heldout_after:.3g} {most.unit} on motion not fitted."
    )
    if far and refined is None:
        text += (
            f" At {', '.join(far)} more than {FAR_ABOVE_NOISE:.0f} times the sensor's noise is left: friction is not "
            "all that the model lacks there; mjfriction diagnose looks for the rest."
        )
    risen = [error.joint for error in errors if error.rms_heldout_after > RISEN * error.rms_before]
    if risen:
        text += f" It rises at {', '.join(risen)}: the stated friction was nearer than this law can be."
    if refined is not None:
        k = int(np.argmax(refined.before))
        text += (
            f" Simulated freely for {refined.seconds:.2g} s at a time, {robot.joints[k]} ends up "
            f"{refined.after[k]:.3g} (RMS) from where it was, {refined.before[k]:.3g} before that was fitted."
        )
    falling = [law.joint for law in laws if law.falls]
    if falling:
        text += (
            f" At {', '.join(falling)} {FASTER}; the level and the damping beyond it are not known, however narrow the "
            "intervals are."
        )
    doubtful = [law.joint for law in laws if not law.trusted and not law.falls]
    if doubtful:
        text += (
            f" At {', '.join(doubtful)} an error is left that is no noise: no law of friction explains it, and "
            "the intervals there are too narrow; mjfriction diagnose looks for its cause."
        )
    return text
