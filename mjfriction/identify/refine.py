"""Refinement on simulated motion: the log's efforts are played into MuJoCo, and where the joints go is compared.

Inverse dynamics asks what effort a measured acceleration needs, and suffers from that acceleration's noise; a
simulation asks where a measured effort leads, and does not.  It runs in stretches that begin where the log says, so
that errors do not pile up; one stretch of a whole log is the open-loop simulation.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import least_squares

from mjfriction.errors import RobotError
from mjfriction.identify.background import Background
from mjfriction.identify.fit import LawFit
from mjfriction.identify.fit import slopes as row_slopes
from mjfriction.identify.gap import Gap
from mjfriction.record.log import Floats, Integers
from mjfriction.robot.robot import Robot
from mjfriction.robot.simulation import not_in_model, robot_laws, robot_spec
from mjfriction.sim.attach import attach
from mjfriction.sim.replay import replay

LONGEST_STEP = 1e-3  # s
COMPARED_EVERY = 0.01  # s between the positions that are compared
MOST_ROUNDS = 15
DIFFERENCE = 1e-3  # of a coordinate, for slopes: what the solver's own rounding leaves alone
FREEDOM = 0.5  # of its coordinate's own size (a factor of e^0.5 for a logarithm), that a parameter may move by usually
PRIOR = 0.02  # weight of a parameter's own distance beside one position error of the size it begins with
LOST = 1e3  # rad or m
IN_MODEL_TOO = frozenset(
    {"effort_sensor", "position_sensor"}
)  # keys whose scale, offset and delay the log is cleared of
SHORTEST = 0.05  # s


@dataclass(frozen=True)
class Stretches:
    """Stretches of a log on the models' clock: where they begin (k, joints), the efforts reported (k, steps, joints),
    and the positions ``measured`` (k, m, joints) at the steps ``compared`` (m,).
    """

    position: Floats
    velocity: Floats
    reported: Floats
    measured: Floats
    compared: Integers
    step: float


@dataclass(frozen=True)
class Refined:
    """The refined laws ``fits``, what they were ``begun`` from, and the robot that holds them.

    ``before`` and ``after`` (joints,) are RMS position errors of the simulation, rad or m, in stretches of ``seconds``.
    """

    robot: Robot
    fits: tuple[LawFit, ...]
    begun: tuple[LawFit, ...]
    seconds: float
    before: Floats
    after: Floats


def cut_stretches(gap: Gap, robot: Robot, seconds: float) -> Stretches:
    """Cut a gap's log into stretches of so many seconds, or of its longest piece where ``seconds`` is infinite.

    Pieces shorter than that are left out; ``robot`` says what its sensors add.  Raises :class:`RobotError` where a
    joint has no effort, the robot holds parts that its MuJoCo model does not, or ``seconds`` is no time to compare.
    """
    if not seconds >= SHORTEST:
        raise RobotError(f"{seconds} s are no stretch to simulate; give {SHORTEST} s or more, or inf for the whole log")
    motion = gap.motion
    lacking = [joint for i, joint in enumerate(robot.joints) if i not in gap.examined]
    if lacking:
        raise RobotError(f"simulated motion needs the efforts of all joints, and {', '.join(lacking)} has none")
    for joint in robot.table.joint:
        beyond = [key for key in not_in_model(joint) if key not in IN_MODEL_TOO]
        if beyond:
            raise RobotError(
                f"joint '{joint.name}': its {', '.join(beyond)} is not in the MuJoCo model, so that simulated motion "
                "cannot be compared; refine without it"
            )
    fine = max(1, int(np.ceil(1.0 / (motion.rate * LONGEST_STEP) - 1e-9)))
    step = 1.0 / (motion.rate * fine)
    zero = np.array([joint.position_sensor.offset for joint in robot.table.joint])
    bounds = np.flatnonzero(np.diff(motion.piece)) + 1
    pieces = list(itertools.pairwise([0, *bounds.tolist(), motion.time.size]))
    longest = max(past - first for first, past in pieces)
    length = int(min(seconds * motion.rate, longest - 1))
    cuts = [(first, s, past) for first, past in pieces for s in range(first, past - length, length)]
    starts = [s for _, s, _ in cuts]
    compared = np.arange(0, length * fine, max(1, round(COMPARED_EVERY / step)))[1:]
    clock = np.arange(length * fine) / fine
    # An effort is held over its step, so that the middle's is taken; a drive that reports late is read ahead.
    delay = np.array([joint.effort_sensor.delay for joint in robot.table.joint])
    middle, late = clock + 0.5 / fine, delay * motion.rate

    def on_steps(values: Floats, at: Floats, ahead: Floats) -> Floats:
        shifted = list(zip(range(ahead.size), ahead, strict=True))
        # What a late drive reports of a stretch's end comes after it, as far as the piece goes.
        return np.stack(
            [
                np.column_stack(
                    [np.interp(s + at + shift, np.arange(first, past), values[first:past, k]) for k, shift in shifted]
                )
                for first, s, past in cuts
            ]
        )

    position = motion.position - zero
    return Stretches(
        position=position[starts],
        velocity=motion.velocity[starts],
        reported=on_steps(motion.torque * gap.per_reported, middle, late),
        measured=on_steps(position, clock, np.zeros(delay.size))[:, compared],
        compared=compared,
        step=step,
    )


def refine(gap: Gap, robot: Robot, fits: Sequence[LawFit], background: Sequence[Background], seconds: float) -> Refined:
    """Refit laws, links and zeros on simulated motion, from where they stand in ``robot``.

    The sum of squared position errors is lowered, every joint's in units of what it begins with; each parameter is held
    near where it stands by what identification usually is off by, and the background moves along what the efforts show
    of it.  Raises what :func:`cut_stretches` raises.
    """
    fixed = cut_stretches(gap, robot, seconds)
    shown = [_shown(part, fits) for part in background]
    ends = np.cumsum([0, *(fit.x.size for fit in fits), *(basis.shape[1] for basis in shown)])
    begin = np.concatenate([*(fit.x for fit in fits), np.zeros(ends[-1] - ends[len(fits)])])
    size = np.concatenate(
        [
            *(FREEDOM * np.where(fit.coordinates.logarithmic, 1.0, np.maximum(np.abs(fit.x), 1e-3)) for fit in fits),
            np.ones(ends[-1] - ends[len(fits)]),
        ]
    )

    def made(x: Floats) -> Robot:
        own = np.split(x, ends[1:-1])
        changed = robot
        for part, basis, along in zip(background, shown, own[len(fits) :], strict=True):
            if np.any(along):
                changed = part.applied(changed, basis @ along)
        for fit, coordinates in zip(fits, own, strict=False):
            term = fit.problem.term(fit.law, fit.coordinates.values(coordinates))
            joint = changed.table.joint[fit.problem.joint]
            changed = changed.with_joint(joint.model_copy(update={"friction": (term,)}))
        return changed

    unit = np.maximum(_rms(_missed(gap, [robot], fixed)[0]), 1e-9)
    weight = 1.0 / (unit * np.sqrt(fixed.measured[..., 0].size))

    def left(x: Floats) -> Floats:
        return _stacked(_missed(gap, [made(x)], fixed)[0] * weight, (x - begin) / size)

    def slopes(x: Floats) -> Floats:
        steps = DIFFERENCE * size
        robots = [made(x), *(made(x + step) for step in np.diag(steps))]
        missed = _missed(gap, robots, fixed) * weight
        columns = [(one - missed[0]).ravel() / step for one, step in zip(missed[1:], steps, strict=True)]
        return np.vstack([np.column_stack(columns), PRIOR * np.diag(1.0 / size)])

    lows, highs = zip(*(fit.coordinates.bounds() for fit in fits), strict=True)
    beside = np.full(begin.size - sum(fit.x.size for fit in fits), np.inf)
    low, high = np.concatenate([*lows, -beside]), np.concatenate([*highs, beside])
    inside = np.clip(begin, np.nextafter(low, np.inf), np.nextafter(high, -np.inf))
    found = least_squares(
        left, inside, jac=slopes, bounds=(low, high), x_scale=size, max_nfev=MOST_ROUNDS, ftol=1e-5, xtol=1e-5
    )
    better = made(np.asarray(found.x))
    moved = tuple(
        replace(fit, x=x, slopes=row_slopes(fit.problem, fit.coordinates, x))
        for fit, x in zip(fits, np.split(found.x, ends[1:-1]), strict=False)
    )
    before, after = (_rms(_missed(gap, [one], fixed)[0]) for one in (robot, better))
    length = fixed.reported.shape[1] * fixed.step
    return Refined(better, moved, tuple(fits), length, before, after)


def _shown(part: Background, fits: Sequence[LawFit]) -> Floats:
    # Along which combinations of a part's strengths, each as large as is usual, the efforts say more than is known
    # beforehand, (strengths, combinations); the others cost a simulation each and move nothing.
    usual = 1.0 / np.sqrt(part.precision)
    gram = np.zeros((usual.size, usual.size))
    for fit in fits:
        if (columns := part.columns.get(fit.problem.joint)) is not None:
            weighted = columns * usual / fit.problem.deviation[:, None]
            gram += weighted.T @ weighted
    power, turned = np.linalg.eigh(gram)
    return np.asarray(usual[:, None] * turned[:, power > 1.0])


def _stacked(missed: Floats, moved: Floats) -> Floats:
    return np.concatenate([missed.ravel(), PRIOR * moved])


def _missed(gap: Gap, robots: Sequence[Robot], stretches: Stretches) -> Floats:
    # Where each robot's simulation ends up, less where the machine was: (robots, stretches, compared, joints).
    models, efforts = [], []
    for robot in robots:
        spec = robot_spec(robot)
        spec.option.timestep = stretches.step
        models.append(attach(spec, robot_laws(robot)))
        efforts.append((stretches.reported - _offset(robot)) / _scale(robot))
    went = replay(models, gap.robot.joints, stretches.position, stretches.velocity, np.array(efforts))
    # What flew away is far off, not undefined.
    return np.nan_to_num(went[:, :, stretches.compared] - stretches.measured, nan=LOST, posinf=LOST, neginf=-LOST)


def _scale(robot: Robot) -> Floats:
    return np.array([joint.effort_sensor.scale for joint in robot.table.joint])


def _offset(robot: Robot) -> Floats:
    return np.array([joint.effort_sensor.offset for joint in robot.table.joint])


def _rms(missed: Floats) -> Floats:
    return np.asarray(np.sqrt(np.mean(np.square(missed), axis=(0, 1))))
