"""A whole identification: a log and a robot in; friction laws with intervals, and the robot that holds them, out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from mjfriction.errors import LogError
from mjfriction.identify.background import Background, OffsetChange, link_changes, offset_changes
from mjfriction.identify.choose import CANDIDATES, Choice, choose_law
from mjfriction.identify.conclude import conclude
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
from mjfriction.progress import Tell, silently
from mjfriction.record.log import Floats, Log
from mjfriction.robot.robot import Robot
from mjfriction.robot.rubbing import forward_share
from mjfriction.robot.schema import FrictionTerm

ROUNDS = 2  # of links by themselves and laws by themselves, before all are taken together


def identify_log(
    log: Log,
    robot: Robot,
    *,
    law: str | None = None,
    side: Side = "joint",
    links: bool = True,
    simulated: float | None = None,
    tell: Tell = silently,
) -> Identification:
    """Fit a friction law to every moving joint of a log that has an effort, and the links' inertias with them.

    ``law`` is the law's name for all joints; without one each joint gets the simplest law that predicts motion not
    fitted as well as any.  Where the log holds passes forward and backward at three speeds or more, the statics come
    from their differences, in which gravity cancels; else, and for what a bristle adds, from the whole motion.  With
    ``links`` the links' masses and centres are refitted too.  The joint's stated friction is replaced.  With
    ``simulated`` all is refined last on simulated motion, in stretches of so many seconds (infinite: the whole log);
    intervals are those of the fit to efforts, widened by what the refinement moved.  ``tell`` is told each step.

    Raises :class:`~mjfriction.errors.LogError`, :class:`~mjfriction.errors.RobotError` or
    :class:`~mjfriction.errors.LawError` when log, robot or law cannot be used.
    """
    names = CANDIDATES if law is None else (find_law(law).name,)
    tell("measuring the gap", 0.0)
    stated = measure_gap(log, robot)
    joints = [j for j in stated.examined if np.ptp(stated.measured[:, j]) > 0.0]
    if not joints:
        raise LogError(
            f"{log.source}: no joint moves and reports an effort or a current that changes; nothing can be identified"
        )
    without = stated.robot
    for joint in joints:
        without = _with_friction(without, joint, ())
    bare = gap_of(without, stated)
    maps = {
        found.joint: found for found in friction_maps(bare.motion, _efforts(bare), constant_speed_phases(bare.motion))
    }
    background = [*(link_changes(bare) if links else []), *offset_changes(bare, joints)]
    friction = _coulomb_viscous_columns(bare, joints)
    target = np.nan_to_num(bare.residual)
    problems = [Problem(bare, joint, side, target[:, joint], _doubted(bare, joint)) for joint in joints]
    fits: list[LawFit] = []
    tried: list[list[Choice]] = []
    for _ in range(ROUNDS):
        laws = np.column_stack([fit.problem.rows(fit.term) for fit in fits]) if fits else None
        background = _unshared(background, joints, fits)
        change, left = _background_fitted(bare, problems, background, friction, laws)
        problems = [
            replace(problem, target=target[:, joint] - _effort_of(background, change, joint)).believed(left[:, i])
            for i, (joint, problem) in enumerate(zip(joints, problems, strict=True))
        ]
        if not fits:
            results: list[tuple[Choice, list[Choice]]] = []
            for problem in problems:
                tell(
                    f"fitting laws, joint {len(results) + 1} of {len(problems)}",
                    0.1 + 0.7 * len(results) / len(problems),
                )
                results.append(choose_law(problem, names))
            fits, tried = [best.fit for best, _ in results], [all_of for _, all_of in results]
            fits = [_from_passes(fit, maps.get(fit.problem.joint)) or fit for fit in fits]
        else:
            pairs = zip(problems, fits, strict=True)
            moved = [(problem, replace(fit, problem=problem)) for problem, fit in pairs]
            fits = [_from_passes(fit, maps.get(problem.joint)) or fit_anew(problem, fit) for problem, fit in moved]
    final = bare.robot
    for part, own in zip(background, change, strict=True):
        final = part.applied(final, own)
    for fit in fits:
        final = _with_friction(final, fit.problem.joint, (fit.term,))
    refined = None
    if simulated is not None:
        tell("refining on simulated motion")
        refined = refine(stated, final, fits, background, simulated)
        final, fits = refined.robot, list(refined.fits)
    return conclude(stated, final, joints, fits, tried, background, maps, refined)


def _with_friction(robot: Robot, joint: int, terms: tuple[FrictionTerm, ...]) -> Robot:
    return robot.with_joint(robot.table.joint[joint].model_copy(update={"friction": terms}))


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
        joint: gap.reported(joint, np.column_stack([forward_share(gap.motion, joint), gap.motion.velocity[:, joint]]))
        for joint in joints
    }


def _unshared(background: Sequence[Background], joints: Sequence[int], fits: Sequence[LawFit]) -> list[Background]:
    # A law with a level for each direction holds the zero of the effort already.
    two_way = {joint for joint, fit in zip(joints, fits, strict=False) if not fit.law.odd}
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


def _from_passes(fit: LawFit, points: FrictionMap | None) -> LawFit | None:
    statics = statics_from_passes(fit, points) if points is not None else None
    if statics is None:
        return None
    values = {**fit.values, **{name: value for name, value in statics.values.items() if name in fit.values}}
    x = fit.coordinates.vector(values)
    return replace(fit, x=x, slopes=slopes(fit.problem, fit.coordinates, x))
