"""A whole identification: a log and a robot in; friction laws with intervals, and the robot that holds them, out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from mjfriction.errors import LogError
from mjfriction.identify.background import Background, OffsetChange, link_changes, offset_changes
from mjfriction.identify.choose import CANDIDATES, Choice, choose_law
from mjfriction.identify.conclude import conclude
from mjfriction.identify.coordinates import Coordinates
from mjfriction.identify.fit import LawFit, fit_anew, slopes
from mjfriction.identify.friction_map import FrictionMap, friction_maps
from mjfriction.identify.gap import Gap, gap_of, measure_gap
from mjfriction.identify.outcome import Identification
from mjfriction.identify.phases import constant_speed_phases
from mjfriction.identify.problem import Problem, Side
from mjfriction.identify.refine import refine
from mjfriction.identify.regression import Columns, Rows, System
from mjfriction.identify.statics import statics_from_passes
from mjfriction.laws.catalog import find_law
from mjfriction.record.log import Floats, Log
from mjfriction.robot.robot import Robot
from mjfriction.robot.rubbing import forward_share

ROUNDS = 2  # of links by themselves and laws by themselves, before all are taken together


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
    intervals are those of the fit to efforts, widened by what the refinement moved.

    Raises :class:`~mjfriction.errors.LogError`, :class:`~mjfriction.errors.RobotError` or
    :class:`~mjfriction.errors.LawError` when log, robot or law cannot be used.
    """
    names = CANDIDATES if law is None else (find_law(law).name,)
    stated = measure_gap(log, robot)
    joints = [j for j in stated.examined if stated.motion.moving[j] and np.ptp(stated.measured[:, j]) > 0.0]
    if not joints:
        raise LogError(
            f"{log.source}: no joint moves and reports an effort or a current that changes; nothing can be identified"
        )
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
    return conclude(stated, final, joints, chosen, tried, background, maps, refined)


def _without_friction(robot: Robot, joints: Sequence[int]) -> Robot:
    for joint in joints:
        robot = robot.with_joint(robot.table.joint[joint].model_copy(update={"friction": ()}))
    return robot


def _with_laws(robot: Robot, joints: Sequence[int], fits: Sequence[LawFit]) -> Robot:
    for joint, fit in zip(joints, fits, strict=True):
        robot = robot.with_joint(robot.table.joint[joint].model_copy(update={"friction": (fit.term,)}))
    return robot


def _efforts(gap: Gap) -> Floats:
    # What the drives gave, less the friction that the robot still states: what is sought, gravity and the rest.
    sensors = [joint.effort_sensor for joint in gap.robot.table.joint]
    scale, offset = (np.array([getattr(sensor, name) for sensor in sensors]) for name in ("scale", "offset"))
    return np.asarray((gap.motion.torque * gap.per_reported - offset) / scale - gap.effort.friction)


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
    statics = statics_from_passes(choice.fit, points) if points is not None else None
    if statics is None:
        return fit_anew(problem, choice.fit)
    values = {
        **choice.fit.values,
        **{name: value for name, value in statics.values.items() if name in choice.fit.values},
    }
    coordinates = Coordinates(law, choice.fit.coordinates.names, choice.fit.coordinates.fixed)
    x = coordinates.vector(values)
    return LawFit(problem, coordinates, x, slopes(problem, coordinates, x))
