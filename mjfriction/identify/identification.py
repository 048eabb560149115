"""Run a whole identification: from a log and a robot to friction laws with intervals and the robot that holds them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from mjfriction.identify.background import Background, OffsetChange, offset_changes
from mjfriction.identify.balance import SPREADS, Balance, as_far_off, balance, first_friction, fitted_friction
from mjfriction.identify.choose import CANDIDATES, Choice, choose_law
from mjfriction.identify.conclude import conclude
from mjfriction.identify.effort_bandwidth import find_bandwidths, with_bandwidths
from mjfriction.identify.fit import LawFit, begun, fit_anew, slopes
from mjfriction.identify.friction_map import friction_maps
from mjfriction.identify.gap import Gap
from mjfriction.identify.link_inertias import link_inertias
from mjfriction.identify.measure import gap_of, measure_gap
from mjfriction.identify.no_map import why_no_map
from mjfriction.identify.outcome import Identification
from mjfriction.identify.pendulum import by_pendulum
from mjfriction.identify.phases import constant_speed_phases
from mjfriction.identify.problem import Problem, Side
from mjfriction.identify.refine import refine
from mjfriction.identify.statics import Passes
from mjfriction.laws.catalog import find_law
from mjfriction.progress import Tell, silently
from mjfriction.record.log import Floats, Log
from mjfriction.robot.friction_tables import FrictionTerm
from mjfriction.robot.robot import Robot

# Alternations between fitting the background and fitting the laws; each leaves the linear part of the other free.
ROUNDS = 3


def identify_log(
    log: Log,
    robot: Robot,
    *,
    law: str | Mapping[str, str] | None = None,
    side: Side = "joint",
    links: bool = True,
    simulated: float | None = None,
    tell: Tell = silently,
) -> Identification:
    """Fit a friction law to every moving joint of a log that has an effort, and the links' inertias with them.

    ``law`` names one law for all joints, or laws by joint.  A joint without a name gets the simplest law that predicts
    held-out motion as well as any.  Where the log holds passes forward and backward at three speeds or more, the static
    parameters come from the differences of these passes, in which gravity cancels.  Otherwise, and for what a bristle
    adds, they come from the whole motion.  With ``links`` the links' inertias are refitted too.  The joint's stated
    friction is replaced.  Where drives turn out to low-pass the efforts they report, everything is refitted through
    that low-pass.  With ``simulated`` everything is refined last on simulated motion, in stretches of that many seconds
    (infinite: the whole log); the intervals are then those of the fit to efforts, widened by how far the refinement
    moved each value.  ``tell`` is called with each step.

    Raises :class:`~mjfriction.errors.LogError`, :class:`~mjfriction.errors.RobotError` or
    :class:`~mjfriction.errors.LawError` when log, robot or law cannot be used.
    """
    wanted = _wanted(law, robot)
    tell("measuring the gap", 0.0)
    stated = measure_gap(log, robot, yielding=0.0)
    found = _fit(stated, wanted, side, links=links, tell=tell)
    bandwidths = find_bandwidths(stated, found.robot)
    if bandwidths:
        # Apply the low-pass to the prediction, so that what it removes is not counted as residual.
        stated = gap_of(with_bandwidths(stated.robot, bandwidths), stated)
        found = _fit(stated, wanted, side, links=links, tell=tell)
    final, fits = found.robot, found.fits
    refined = None
    if simulated is not None:
        tell("refining on simulated motion")
        refined = refine(stated, final, fits, found.parts, simulated)
        final, fits = refined.robot, list(refined.fits)
    return conclude(stated, final, found.joints, fits, found.tried, found.parts, found.passes, refined, bandwidths)


@dataclass(frozen=True)
class _Fit:
    robot: Robot
    joints: list[int]
    fits: list[LawFit]
    tried: list[list[Choice]]
    parts: list[Background]
    passes: dict[int, Passes]


def _fit(stated: Gap, wanted: Sequence[Sequence[str]], side: Side, *, links: bool, tell: Tell) -> _Fit:
    joints = list(stated.examined)
    without = stated.robot
    for joint in joints:
        without = _with_friction(without, joint, ())
    bare = gap_of(without, stated)
    passes = _passes(bare, joints)
    parts = offset_changes(bare, joints)
    friction = {joint: first_friction(bare, joint) for joint in joints}
    deviation = {joint: _doubted(bare, joint) for joint in joints}
    if links and (inertias := link_inertias(bare, SPREADS[0])) is not None:
        parts = [as_far_off(inertias, bare, parts, friction, deviation), *parts]
    fits: list[LawFit] = []
    tried: list[list[Choice]] = []
    for _ in range(ROUNDS):
        parts = _unshared(parts, joints, fits)
        fitted = balance(bare, parts, friction, deviation)
        problems = [_problem(bare, joint, side, fitted, deviation[joint]) for joint in joints]
        if not fits:
            results: list[tuple[Choice, list[Choice]]] = []
            for problem in problems:
                tell(
                    f"fitting laws, joint {len(results) + 1} of {len(problems)}",
                    0.1 + 0.7 * len(results) / len(problems),
                )
                told = _told_by_passes(problem, wanted[problem.joint], passes[problem.joint])
                results.append(told or _chosen(problem, wanted[problem.joint], passes[problem.joint]))
            fits, tried = [best.fit for best, _ in results], [all_of for _, all_of in results]
        else:
            pairs = zip(problems, fits, strict=True)
            fits = [_again(problem, fit, passes[problem.joint]) for problem, fit in pairs]
        deviation = {joint: problem.deviation for joint, problem in zip(joints, problems, strict=True)}
        passed = [_from_passes(fit, passes[fit.problem.joint]) for fit in fits]
        fits = [own or fit for own, fit in zip(passed, fits, strict=True)]
        friction = {
            joint: fitted_friction(fit, free=own is None) for joint, fit, own in zip(joints, fits, passed, strict=True)
        }
        if all(own is not None and not own.law.has_state for own in passed):
            break  # values that come entirely from the passes do not depend on the background
    parts = _unshared(parts, joints, fits)
    held = {joint: fitted_friction(fit, free=False) for joint, fit in zip(joints, fits, strict=True)}
    fitted = balance(bare, parts, held, deviation)
    final = bare.robot
    for part, change in zip(parts, fitted.changes, strict=True):
        final = part.applied(final, change)
    for fit in fits:
        final = _with_friction(final, fit.problem.joint, (fit.term,))
    return _Fit(final, joints, fits, tried, parts, passes)


def _wanted(law: str | Mapping[str, str] | None, robot: Robot) -> list[Sequence[str]]:
    # The candidate laws of each joint.
    if law is None or isinstance(law, str):
        return [CANDIDATES if law is None else (find_law(law).name,)] * len(robot.joints)
    named = {robot.joint(joint).name: (find_law(name).name,) for joint, name in law.items()}
    return [named.get(joint, CANDIDATES) for joint in robot.joints]


def _with_friction(robot: Robot, joint: int, terms: tuple[FrictionTerm, ...]) -> Robot:
    return robot.with_joint(robot.table.joint[joint].model_copy(update={"friction": terms}))


def _efforts(gap: Gap) -> Floats:
    # The efforts that the drives gave, less the friction that the robot still states.  They hold the friction sought,
    # gravity and the rest.
    sensors = [joint.effort_sensor for joint in gap.robot.table.joint]
    scale, offset = (np.array([getattr(sensor, name) for sensor in sensors]) for name in ("scale", "offset"))
    return np.asarray((gap.motion.torque * gap.per_reported - offset) / scale - gap.effort.friction)


def _doubted(gap: Gap, joint: int) -> Floats:
    size = float(np.sqrt(np.mean(np.square(gap.residual[:, joint]))))
    return np.hypot(size, gap.doubt[:, joint])


def _problem(gap: Gap, joint: int, side: Side, fitted: Balance, deviation: Floats) -> Problem:
    target = np.nan_to_num(gap.residual[:, joint]) - fitted.effort(joint)
    return Problem(gap, joint, side, target, deviation, fitted.beside(joint)).believed(fitted.left()[:, joint])


def _unshared(background: Sequence[Background], joints: Sequence[int], fits: Sequence[LawFit]) -> list[Background]:
    # A law with its own level for each direction already contains the effort's offset.
    two_way = {joint for joint, fit in zip(joints, fits, strict=False) if not fit.law.odd}
    return [part for part in background if not (isinstance(part, OffsetChange) and part.index in two_way)]


def _passes(gap: Gap, joints: Sequence[int]) -> dict[int, Passes]:
    phases, efforts = constant_speed_phases(gap.motion), _efforts(gap)
    points = {found.joint: found for found in friction_maps(gap.motion, efforts, phases)}
    return {
        joint: Passes(points[joint], by_pendulum(gap.motion, efforts[:, joint], gap.robot, gap.body, phases, joint))
        if joint in points
        else Passes(None, lacking=why_no_map(gap.motion, phases, joint))
        for joint in joints
    }


def _told_by_passes(problem: Problem, names: Sequence[str], passes: Passes) -> tuple[Choice, list[Choice]] | None:
    # The only law requested, where the joint's passes determine it completely: the rows then have nothing to add.
    law = find_law(names[0])
    if passes.points is None or len(names) > 1 or law.has_state:
        return None
    fit = _from_passes(begun(problem, law), passes)
    if fit is None:
        return None
    choice = Choice(fit, fit.heldout())
    return choice, [choice]


def _chosen(problem: Problem, names: Sequence[str], passes: Passes) -> tuple[Choice, list[Choice]]:
    # Among the laws that passes can determine, the passes choose one.  Laws that differ between directions or read the
    # load compete with that one on all rows.  Passes say little about bristles, and only where they reverse, so laws
    # with a bristle are then fitted only on request.
    ratio = problem.gap.robot.table.joint[problem.joint].actuator.gear_ratio
    first = passes.chosen(names, problem.side, ratio) if len(names) > 1 else None
    if first is not None:
        laws = [find_law(name) for name in names]
        names = [law.name for law in laws if law.name == first or not (passes.tells(law) or law.has_state)]
    return choose_law(problem, names, first)


def _again(problem: Problem, fit: LawFit, passes: Passes) -> LawFit:
    moved = replace(fit, problem=problem)
    if not fit.law.has_state and passes.statics(moved) is not None:
        return moved  # the passes determine all of it
    return fit_anew(problem, fit)


def _from_passes(fit: LawFit, passes: Passes) -> LawFit | None:
    statics = passes.statics(fit)
    if statics is None:
        return None
    now = fit.values
    values = {**now, **{name: value for name, value in statics.values.items() if name in now}}
    x = fit.coordinates.vector(values)
    return replace(fit, x=x, slopes=slopes(fit.problem, fit.coordinates, x))
