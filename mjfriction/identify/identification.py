"""A whole identification: a log and a robot in; friction laws with intervals, and the robot that holds them, out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.stats import t as student

from mjfriction.errors import LogError
from mjfriction.identify.background import Background, OffsetChange, link_changes, offset_changes
from mjfriction.identify.checks import notes
from mjfriction.identify.choose import CANDIDATES, Choice, choose_law
from mjfriction.identify.coordinates import Coordinates
from mjfriction.identify.fit import STATIC_SIBLING, LawFit, fit_anew, slopes
from mjfriction.identify.fitted import Fitted
from mjfriction.identify.friction_map import FrictionMap, friction_maps
from mjfriction.identify.gap import Gap, gap_of, measure_gap
from mjfriction.identify.joint_error import JointError, joint_error
from mjfriction.identify.map_fit import MapFit, arctan_procedure, fit_map
from mjfriction.identify.outcome import Candidate, Identification, JointLaw
from mjfriction.identify.phases import constant_speed_phases
from mjfriction.identify.problem import Problem, Side
from mjfriction.identify.refine import Refined, refine
from mjfriction.identify.regression import Columns, Normal, Rows, System
from mjfriction.identify.structure import Structure, find_structure
from mjfriction.laws.arctan import ARCTAN
from mjfriction.laws.catalog import find_law
from mjfriction.record.log import Floats, Log
from mjfriction.robot.robot import Robot
from mjfriction.robot.rubbing import forward_share

ROUNDS = 2  # of links by themselves and laws by themselves, before all are taken together
STRUCTURED = 0.1  # share of what is left that may follow a covariate before intervals are not to be believed
LEAST_EFFORT = 0.01  # of the joint's RMS effort, that what follows it must reach besides
FREE, PASSES = "free motion", "forward and backward passes"


def identify_log(
    log: Log,
    robot: Robot,
    *,
    law: str | None = None,
    side: Side = "joint",
    links: bool = True,
    simulated: float | None = None,
) -> Identification:
    """Fit a friction law to every moving joint of a log that has an effort, and the links' inertias with them.

    ``law`` is the law's name for all joints; without one each joint gets the simplest law that predicts motion not
    fitted as well as any.  Where the log holds passes forward and backward at three speeds or more, the statics come
    from their differences, in which gravity cancels; else, and for what a bristle adds, from the whole motion.  With
    ``links`` the links' masses and centres are refitted too.  The joint's stated friction is replaced.  With
    ``simulated`` all is refined last on simulated motion, in stretches of so many seconds (infinite: the whole log);
    intervals stay those of the fit to efforts.

    Raises :class:`~mjfriction.errors.LogError`, :class:`~mjfriction.errors.RobotError` or
    :class:`~mjfriction.errors.LawError` when log, robot or law cannot be used.
    """
    names = CANDIDATES if law is None else (find_law(law).name,)
    stated = measure_gap(log, robot)
    joints = [joint for joint in stated.examined if stated.motion.moving[joint]]
    if not joints:
        raise LogError(f"{log.source}: no joint with an effort or a current moves; nothing can be identified")
    bare = gap_of(_without_friction(stated.robot, joints), stated)
    maps = {
        found.joint: found for found in friction_maps(bare.motion, _efforts(bare), constant_speed_phases(bare.motion))
    }
    background = [*(link_changes(bare) if links else []), *offset_changes(bare, joints)]
    friction = _coulomb_viscous_columns(bare, joints)
    target = np.nan_to_num(bare.residual)
    problems = [Problem(bare, joint, side, target[:, joint], _doubted(bare, joint)) for joint in joints]
    chosen: list[Choice] = []
    tried: list[list[Choice]] = []
    for number in range(ROUNDS):
        fitted = np.column_stack([choice.fit.problem.rows(choice.fit.term) for choice in chosen]) if chosen else None
        background = _unshared(background, joints, chosen)
        change, left = _background_fitted(bare, problems, background, friction, fitted)
        problems = [
            replace(problem, target=target[:, joint] - _effort_of(background, change, joint)).believed(left[:, i])
            for i, (joint, problem) in enumerate(zip(joints, problems, strict=True))
        ]
        if number == 0:
            results = [_joint_law(problem, names, maps.get(problem.joint)) for problem in problems]
            chosen, tried = [best for best, _ in results], [all_of for _, all_of in results]
        else:
            chosen = [
                Choice(fit := _refitted(problem, choice, maps.get(problem.joint)), fit.heldout())
                for problem, choice in zip(problems, chosen, strict=True)
            ]
    final = bare.robot
    for part, own in zip(background, change, strict=True):
        final = part.applied(final, own)
    final = _with_laws(final, joints, [choice.fit for choice in chosen])
    refined = None
    if simulated is not None:
        refined = refine(stated, final, [choice.fit for choice in chosen], background, simulated)
        final = refined.robot
        chosen = [Choice(fit, fit.heldout()) for fit in refined.fits]
        maps = {}
    return _outcome(stated, final, joints, chosen, tried, background, maps, refined)


def _without_friction(robot: Robot, joints: Sequence[int]) -> Robot:
    for joint in joints:
        robot = robot.with_joint(robot.table.joint[joint].model_copy(update={"friction": ()}))
    return robot


def _with_laws(robot: Robot, joints: Sequence[int], fits: Sequence[LawFit]) -> Robot:
    for joint, fit in zip(joints, fits, strict=True):
        robot = robot.with_joint(robot.table.joint[joint].model_copy(update={"friction": (fit.term,)}))
    return robot


def _efforts(gap: Gap) -> Floats:
    return gap.motion.torque * gap.per_reported


def _doubted(gap: Gap, joint: int) -> Floats:
    size = float(np.sqrt(np.mean(np.square(gap.residual[:, joint]))))
    return np.hypot(size, gap.doubt[:, joint])


def _coulomb_viscous_columns(gap: Gap, joints: Sequence[int]) -> dict[int, Floats]:
    return {
        joint: gap.chain.rows(np.column_stack([forward_share(gap.motion, joint), gap.motion.velocity[:, joint]]))
        for joint in joints
    }


def _unshared(background: Sequence[Background], joints: Sequence[int], chosen: Sequence[Choice]) -> list[Background]:
    # A law with a level for each direction holds the zero of the effort already.
    two_way = {joint for joint, choice in zip(joints, chosen, strict=False) if not choice.fit.law.odd}
    return [part for part in background if not (isinstance(part, OffsetChange) and part.index in two_way)]


def _effort_of(background: Sequence[Background], change: Sequence[Floats], joint: int) -> Floats:
    parts = [part.columns[joint] @ own for part, own in zip(background, change, strict=True) if joint in part.columns]
    return np.asarray(sum(parts, start=np.zeros(1)))


def _background_fitted(
    gap: Gap,
    problems: Sequence[Problem],
    background: Sequence[Background],
    friction: dict[int, Floats],
    fitted: Floats | None,
) -> tuple[list[Floats], Floats]:
    """Return the strengths of each part of the background and what is left at the problems' joints (rows, joints).

    Friction is as ``fitted`` (rows, joints) by laws, or, before there are any, a level and a damping of every joint.
    """
    target = np.nan_to_num(gap.residual)
    weight = np.zeros_like(target)
    for i, problem in enumerate(problems):
        weight[:, problem.joint] = 1.0 / problem.deviation
        if fitted is not None:
            target[:, problem.joint] -= fitted[:, i]
    blocks: list[Columns] = [part.columns for part in background]
    precisions = [part.precision for part in background]
    if fitted is None:
        for joint, own in friction.items():
            blocks.append({joint: own})
            precisions.append(np.zeros(2))
    system = System(Rows(target, weight, gap.blocks.row), blocks, precisions)
    strengths = system.normal.strengths(np.ones(gap.blocks.count, dtype=bool))
    left = system.residual(strengths)[:, [problem.joint for problem in problems]]
    ends = np.cumsum([part.precision.size for part in background])
    return np.split(strengths, ends)[: len(background)], left


def _joint_law(problem: Problem, names: Sequence[str], points: FrictionMap | None) -> tuple[Choice, list[Choice]]:
    best, choices = choose_law(problem, names)
    if points is not None:
        fit = _refitted(problem, best, points)
        best = Choice(fit, fit.heldout())
    return best, choices


def _refitted(problem: Problem, choice: Choice, points: FrictionMap | None) -> LawFit:
    law = choice.fit.law
    statics = _statics(problem, choice, points) if points is not None else None
    if statics is None:
        return fit_anew(problem, choice.fit)
    values = {
        **choice.fit.values,
        **{name: value for name, value in statics.values.items() if name in choice.fit.values},
    }
    coordinates = Coordinates(law, choice.fit.coordinates.names, choice.fit.coordinates.fixed)
    x = coordinates.vector(values)
    return LawFit(problem, coordinates, x, slopes(problem, coordinates, x))


def _statics(problem: Problem, choice: Choice, points: FrictionMap) -> MapFit | None:
    law = find_law(STATIC_SIBLING.get(choice.fit.law.name, choice.fit.law.name))
    ratio = problem.gap.robot.table.joint[problem.joint].actuator.gear_ratio
    # What reads more than the speed, or differs between directions, does not show in their difference.
    if law.reads or not law.odd or law.name == "asymmetric":
        return None
    try:
        return fit_map(points, law, problem.side, ratio)
    except LogError:
        return None


def _outcome(
    stated: Gap,
    robot: Robot,
    joints: Sequence[int],
    chosen: Sequence[Choice],
    tried: Sequence[Sequence[Choice]],
    background: Sequence[Background],
    maps: dict[int, FrictionMap],
    refined: Refined | None,
) -> Identification:
    gap = gap_of(robot, stated)
    normal, system = _taken_together(gap, joints, chosen, background)
    every = np.ones(gap.blocks.count, dtype=bool)
    step = normal.strengths(every)
    covariance = _covariance(system, step, gap)
    quantile = float(student.ppf(0.975, gap.blocks.groups - 1))
    heldout = np.array(gap.residual)
    for fold in gap.blocks.folds:
        rows = fold[gap.blocks.row]
        heldout[rows] = system.residual(normal.strengths(~fold))[rows]
    after = find_structure(gap, np.nan_to_num(heldout))
    laws, errors, place = [], [], 0
    for joint, choice, others in zip(joints, chosen, tried, strict=True):
        fit = choice.fit
        own = slice(place, place + fit.x.size)
        place += fit.x.size
        worst = max((s for s in after if s.joint == gap.robot.joints[joint]), key=lambda s: s.share)
        points = maps.get(joint)
        statics = _statics(fit.problem, choice, points) if points is not None else None
        laws.append(_law(gap, joint, fit, covariance[own, own], quantile, others, worst, statics, points))
        errors.append(joint_error(stated, joint, gap.residual, heldout))
    half = quantile * np.sqrt(np.maximum(np.diag(covariance), 0.0))
    beside: list[Fitted] = []
    for part in background:
        beside += part.fitted(robot, half[place : place + part.precision.size])
        place += part.precision.size
    return Identification(
        gap=stated,
        robot=robot,
        joints=tuple(errors),
        laws=tuple(laws),
        background=tuple(beside),
        heldout=heldout,
        summary=_summary(robot, errors, laws, refined),
        simulated=refined,
    )


def _taken_together(
    gap: Gap, joints: Sequence[int], chosen: Sequence[Choice], background: Sequence[Background]
) -> tuple[Normal, System]:
    # A further step of everything at once, from where all stand: what intervals and held-out errors are drawn from.
    target = np.nan_to_num(gap.residual)
    weight = np.zeros_like(target)
    blocks: list[Columns] = []
    precisions: list[Floats] = []
    for joint, choice in zip(joints, chosen, strict=True):
        weight[:, joint] = 1.0 / choice.fit.problem.believed(target[:, joint]).deviation
        blocks.append({joint: choice.fit.slopes})
        precisions.append(choice.fit.precision)
    blocks += [part.columns for part in background]
    precisions += [part.precision for part in background]
    system = System(Rows(target, weight, gap.blocks.row), blocks, precisions)
    return system.normal, system


def _covariance(system: System, step: Floats, gap: Gap) -> Floats:
    # The larger of the two, number by number: coloured noise makes the one for white noise too small, few blocks the
    # clustered one.  White noise is as large as what is left, not as the doubt about reversals allows.
    normal, weight = system.normal, system.rows.weight
    left = (system.residual(step) * weight)[weight > 0.0]
    spread = float(np.sum(np.square(left))) / max(1, left.size - step.size)
    clustered, white = normal.covariance(step, gap.blocks.group), spread * normal.white_covariance()
    grow = np.sqrt(np.maximum(1.0, np.diag(white) / np.maximum(np.diag(clustered), 1e-300)))
    return np.asarray(clustered * np.outer(grow, grow))


def _law(
    gap: Gap,
    joint: int,
    fit: LawFit,
    covariance: Floats,
    quantile: float,
    others: Sequence[Choice],
    worst: Structure,
    statics: MapFit | None,
    points: FrictionMap | None,
) -> JointLaw:
    sliding = bool(gap.body.sliding[joint])
    turned = fit.coordinates.slopes(fit.x)
    spread = turned @ covariance @ turned.T
    half = quantile * np.sqrt(np.maximum(np.diag(spread), 0.0))
    if statics is not None:
        half = np.array(
            [statics.half.get(name, own) for name, own in zip(fit.coordinates.names, half.tolist(), strict=True)]
        )
    said = notes(fit, half, spread)
    parameters = []
    for name, width in zip(fit.coordinates.names, half, strict=True):
        declared = fit.law.parameter(name)
        value = fit.values[name]
        low, high = (float(np.clip(value + s * width, declared.lower, declared.upper)) for s in (-1.0, 1.0))
        unit = declared.unit_for(sliding=sliding and fit.problem.side == "joint")
        parameters.append(Fitted(name, declared.meaning, unit, value, low, high, said.get(name, "")))
    unit_size = abs(float(gap.per_reported[joint]))
    candidates = [
        Candidate(
            choice.fit.law.name,
            choice.parameters,
            gap.rms(_heldout_rows(choice), joint) / unit_size,
        )
        for choice in others
    ]
    return JointLaw(
        joint=gap.robot.joints[joint],
        fit=fit,
        how=PASSES if statics is not None else FREE,
        parameters=tuple(parameters),
        candidates=tuple(candidates),
        structure=worst.share,
        follows=worst.covariate,
        trusted=not _structured(gap, joint, worst),
        passes=points,
        by_slope=_by_slope(fit, points),
    )


def _structured(gap: Gap, joint: int, worst: Structure) -> bool:
    size = np.sqrt(max(worst.share, 0.0)) * gap.rms(gap.residual[:, joint], joint)
    return bool(worst.share > STRUCTURED and size > LEAST_EFFORT * gap.rms(gap.measured[:, joint], joint))


def _by_slope(fit: LawFit, points: FrictionMap | None) -> MapFit | None:
    if points is None or STATIC_SIBLING.get(fit.law.name, fit.law.name) != ARCTAN.name:
        return None
    try:
        ratio = fit.problem.gap.robot.table.joint[fit.problem.joint].actuator.gear_ratio
        return arctan_procedure(points, fit.problem.side, ratio)
    except LogError:
        return None


def _heldout_rows(choice: Choice) -> Floats:
    fit, normal = choice.fit, choice.fit.normal()
    blocks = fit.problem.gap.blocks
    out = fit.left
    for fold in blocks.folds:
        rows = fold[blocks.row]
        out[rows] -= fit.slopes[rows] @ normal.strengths(~fold)
    return out


def _summary(robot: Robot, errors: Sequence[JointError], laws: Sequence[JointLaw], refined: Refined | None) -> str:
    counted: dict[str, int] = {}
    for law in laws:
        counted[law.fit.law.name] = counted.get(law.fit.law.name, 0) + 1
    listed = ", ".join(f"{name} at {count} joint{'s' * (count > 1)}" for name, count in counted.items())
    worst = max(errors, key=lambda error: error.rms_before / max(error.rms_heldout_after, 1e-300))
    text = (
        f"Friction of '{robot.name}' identified: {listed}; the error of {worst.joint} falls from "
        f"{worst.rms_before:.3g} to {worst.rms_heldout_after:.3g} {worst.unit} on motion not fitted."
    )
    if refined is not None:
        k = int(np.argmax(refined.before))
        text += (
            f" Simulated freely for {refined.seconds:.2g} s at a time, {robot.joints[k]} ends up "
            f"{refined.after[k]:.3g} (RMS) from where it was, {refined.before[k]:.3g} before that was fitted."
        )
    doubtful = [law.joint for law in laws if not law.trusted]
    if doubtful:
        text += (
            f" At {', '.join(doubtful)} an error is left that follows the motion: no law of friction explains it, and "
            "the intervals there are too narrow; mjfriction diagnose looks for its cause."
        )
    return text
