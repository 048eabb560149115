"""Refinement on simulated motion: the log's efforts drive a MuJoCo model, and where the joints go is compared.

Inverse dynamics asks what effort a measured acceleration needs, and suffers from the noise of that acceleration.  A
simulation asks where a measured effort leads, and does not.  It runs in stretches that begin where the log says, so
that errors do not accumulate; a single stretch over the whole log is the open-loop simulation.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import least_squares

from mjfriction.identify.background import Background
from mjfriction.identify.fit import LawFit
from mjfriction.identify.fit import slopes as row_slopes
from mjfriction.identify.gap import Gap
from mjfriction.identify.stretches import cut_stretches, missed, rms
from mjfriction.record.log import Floats
from mjfriction.robot.robot import Robot

MOST_ROUNDS = 15
# Step for slopes, as a share of a coordinate's size: large enough not to be lost in the solver's rounding.
DIFFERENCE = 1e-3
# Share of its coordinate's own size by which a parameter usually moves (a factor of e^0.5 for a logarithm).
FREEDOM = 0.5
PRIOR = 0.02  # weight of a parameter's own move, relative to one position error of the size at the start


@dataclass(frozen=True)
class Refined:
    """The refined laws ``fits``, those they were ``begun`` from, and the robot that holds them.

    ``before`` and ``after`` (joints,) are RMS position errors of the simulation, rad or m, in stretches of ``seconds``.
    """

    robot: Robot
    fits: tuple[LawFit, ...]
    begun: tuple[LawFit, ...]
    seconds: float
    before: Floats
    after: Floats


def refine(gap: Gap, robot: Robot, fits: Sequence[LawFit], background: Sequence[Background], seconds: float) -> Refined:
    """Refit laws, links and offsets on simulated motion, starting from their values in ``robot``.

    This lowers the sum of squared position errors, each joint's in units of its initial error.  Each parameter is held
    near its start by how far off identification usually is; the background moves only along combinations that the
    efforts show.  Raises what :func:`cut_stretches` raises.
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

    unit = np.maximum(rms(missed(gap, [robot], fixed)[0]), 1e-9)
    weight = 1.0 / (unit * np.sqrt(fixed.measured[..., 0].size))

    def left(x: Floats) -> Floats:
        return _stacked(missed(gap, [made(x)], fixed)[0] * weight, (x - begin) / size)

    def slopes(x: Floats) -> Floats:
        steps = DIFFERENCE * size
        robots = [made(x), *(made(x + step) for step in np.diag(steps))]
        off = missed(gap, robots, fixed) * weight
        columns = [(one - off[0]).ravel() / step for one, step in zip(off[1:], steps, strict=True)]
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
    before, after = (rms(missed(gap, [one], fixed)[0]) for one in (robot, better))
    return Refined(better, moved, tuple(fits), fixed.seconds, before, after)


def _shown(part: Background, fits: Sequence[LawFit]) -> Floats:
    # The combinations of a part's strengths, each scaled to its usual size, on which the efforts say more than the
    # prior, (strengths, combinations).  The others would each cost a simulation and move nothing.
    usual = 1.0 / np.sqrt(part.precision)
    gram = np.zeros((usual.size, usual.size))
    for fit in fits:
        if (columns := part.columns.get(fit.problem.joint)) is not None:
            weighted = columns * usual / fit.problem.deviation[:, None]
            gram += weighted.T @ weighted
    power, turned = np.linalg.eigh(gram)
    return np.asarray(usual[:, None] * turned[:, power > 1.0])


def _stacked(off: Floats, moved: Floats) -> Floats:
    return np.concatenate([off.ravel(), PRIOR * moved])
