"""How many elements a law needs at a joint, and where their fit starts: added one by one by held-out error."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from mjfriction.identify.doubt import DOUBT_PERIODS
from mjfriction.identify.elements import Elements, Springs, Waves, elements_of_law
from mjfriction.identify.problem import Problem
from mjfriction.identify.regression import Columns, Rows, System
from mjfriction.identify.stroke_waves import STEPS_PER_LOBE, wavenumbers, waves_at_rows
from mjfriction.laws.law import Law
from mjfriction.laws.rules import Values, array
from mjfriction.record.log import Floats
from mjfriction.robot.friction_tables import FrictionTerm

MOST = 8  # elements
TRAVELS = 16  # rungs of the ladder of travels at which springs may break away
LONGEST = 0.3  # longest of these travels, as a share of the stroke
# Standard errors, and share of the held-out squared error, by which a further element must lower it.
STANDARD_ERRORS, LEAST_GAIN = 3.0, 0.02
SCREENED_ROWS = 2000
Arrays = dict[str, tuple[float, ...]]


def first_elements(problem: Problem, law: Law) -> tuple[Elements, Arrays]:
    """Return a law's elements, as many as the joint needs, and values from which to start their fit, by least squares.

    They are the springs of a Maxwell-slip model on a ladder of travels, or waves of the level on a grid of wavenumbers.
    They are added one by one where they lower the error most, as long as the held-out error falls by three standard
    errors and a fiftieth.
    """
    return _waves(problem) if isinstance(elements_of_law(law, 1), Waves) else _springs(problem)


def _springs(problem: Problem) -> tuple[Elements, Arrays]:
    gap, joint = problem.gap, problem.joint
    ratio = abs(gap.robot.table.joint[joint].actuator.gear_ratio) if problem.side == "motor" else 1.0
    blurred = float(gap.doubt_speed[joint] * DOUBT_PERIODS / gap.motion.cutoff)
    stroke = float(np.ptp(gap.motion.position[:, joint]))
    ladder = ratio * np.geomspace(min(blurred, 0.01 * stroke), LONGEST * stroke, TRAVELS)

    def plays(travel: float) -> Floats:
        elements = {"stiffness": (1.0 / travel,), "level": (1.0,)}
        return problem.rows(
            FrictionTerm(law="maxwell_slip", side=problem.side, parameters={"viscous": 0.0, **elements})
        )

    candidates = np.column_stack([plays(float(travel)) for travel in ladder])
    chosen, levels = _grown(
        problem, _lines(problem, "viscous"), candidates[:, :, None], lambda own: bool(own[0] > 0.0), apart=1
    )
    if not chosen:
        chosen, levels = [0], np.array([[problem.usual().level]])
    order = np.argsort(chosen)
    travel, level = ladder[np.array(chosen)[order]], levels[order, 0]
    return Springs(len(chosen)), {"level": tuple(level.tolist()), "stiffness": tuple((level / travel).tolist())}


def springs_of(law: Law, values: Values) -> tuple[Elements, Arrays]:
    """Return the springs of a Maxwell-slip model as elements of another law, and values for them."""
    level, stiffness = array(values, "level"), array(values, "stiffness")
    elements = elements_of_law(law, len(level))
    if not (isinstance(elements, Springs) and elements.shares):
        return elements, {"level": tuple(level), "stiffness": tuple(stiffness)}
    return elements, {"share": tuple(own / math.fsum(level) for own in level), "stiffness": tuple(stiffness)}


def _waves(problem: Problem) -> tuple[Elements, Arrays]:
    gap, joint = problem.gap, problem.joint
    grid = wavenumbers(gap, joint, turns=True)
    base = np.hstack([_lines(problem, "viscous"), _lines(problem, "coulomb")])
    ratio = problem.gap.robot.table.joint[joint].actuator.gear_ratio if problem.side == "motor" else 1.0
    chosen, strengths = _grown(
        problem,
        base,
        waves_at_rows(gap, joint, grid, 1, turns=True),
        lambda own: bool(np.any(own != 0.0)),
        apart=math.ceil(STEPS_PER_LOBE),
    )
    if not chosen:
        chosen, strengths = [0], np.zeros((1, 2))
    # A law on the motor's side reads the position of the joint itself, so only the amplitudes are converted.
    return Waves(len(chosen)), {
        "wavenumber": tuple(grid[chosen].tolist()),
        "cosine": tuple((strengths[:, 0] / abs(ratio)).tolist()),
        "sine": tuple((strengths[:, 1] / abs(ratio)).tolist()),
    }


def _lines(problem: Problem, name: str) -> Floats:
    parameters = {"coulomb": 0.0, "viscous": 0.0, name: 1.0}
    return problem.rows(FrictionTerm(law="coulomb_viscous", side=problem.side, parameters=parameters))[:, None]


def _grown(
    problem: Problem, base: Floats, candidates: Floats, allowed: Callable[[Floats], bool], *, apart: int
) -> tuple[list[int], Floats]:
    # Which candidates (rows, n, m) are selected, in order, and their strengths (taken, m) beside ``base`` (rows, b).
    # No two are nearer than ``apart`` in the list of candidates.
    beside = problem.beside
    rows = Rows(
        (problem.target - beside.columns @ beside.expected)[:, None],
        1.0 / problem.deviation[:, None],
        problem.gap.blocks.row,
    )
    every = max(1, problem.target.size // SCREENED_ROWS)
    free, width = np.zeros(base.shape[1]), candidates.shape[2]
    blocks: list[Columns] = [{0: base}, {0: beside.columns}]
    precisions = [free, beside.precision]
    chosen: list[int] = []
    system = System(rows, blocks, precisions)
    held = system.normal.heldout_errors(problem.gap.blocks.folds)[0]
    while len(chosen) < MOST:
        strengths, gains = system.screen({0: candidates[::every]}, every)
        near = {i + d for i in chosen for d in range(1 - apart, apart)}
        able = [i for i in range(gains.size) if i not in near and allowed(strengths[i])]
        best = max(able, key=lambda i: float(gains[i]), default=None)
        if best is None:
            break
        blocks = [*blocks, {0: candidates[:, best]}]
        precisions = [*precisions, np.zeros(width)]
        further = System(rows, blocks, precisions)
        after = further.normal.heldout_errors(problem.gap.blocks.folds)[0]
        better = held - after
        error = STANDARD_ERRORS * float(np.std(better, ddof=1)) * np.sqrt(better.size)
        whole = further.normal.fitted[-width * (len(chosen) + 1) :]
        own = whole.reshape(-1, width)
        if np.sum(better) <= max(error, LEAST_GAIN * float(np.sum(held))) or not all(map(allowed, own)):
            break
        chosen, system, held = [*chosen, best], further, after
    count = width * len(chosen)
    whole = system.normal.fitted
    return chosen, whole[whole.size - count :].reshape(-1, width)
