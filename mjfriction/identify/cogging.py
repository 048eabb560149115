"""Cogging from passes at constant speed: what repeats along the stroke and does not turn with the direction."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mjfriction.errors import LogError
from mjfriction.identify.friction_course import FrictionCourse
from mjfriction.identify.phases import Phase
from mjfriction.laws.law import Floats
from mjfriction.robot.table import Wave

SURE = 4.0  # deviations; smaller waves are left out
COLOUR = 4.0  # factor by which coloured noise widens the deviations, as passes are repeated at few speeds


def cogging_waves(
    course: FrictionCourse, phases: Sequence[Phase], wavenumbers: Sequence[float], least: float = 0.0
) -> tuple[Wave, ...]:
    """Return the waves of a joint's effort at given wavenumbers (1/m or 1/rad), by least squares over its passes.

    Every pass has a level of its own, so that friction of any law, in either direction, stays out of the waves.  Waves
    smaller than ``least`` (N·m or N) or than four deviations are left out.  Raises :class:`LogError` where the joint
    has not passed in both directions.
    """
    own = [phase for phase in phases if phase.joint == course.joint]
    if len({phase.velocity > 0.0 for phase in own}) < 2:
        raise LogError("cogging is told from friction by passes in both directions; plan --protocol forward_backward")
    rows = [slice(phase.first, phase.past) for phase in own]
    place = np.concatenate([course.position[row] for row in rows])
    force = np.concatenate([course.friction[row] - np.mean(course.friction[row]) for row in rows])
    waves_at = np.column_stack([wave(k * place) for k in wavenumbers for wave in (np.cos, np.sin)])
    # Friction may vary along the stroke too; its waves turn with the direction and have columns of their own.
    which = np.repeat(np.arange(len(rows)), [row.stop - row.start for row in rows])
    turning = np.sign([phase.velocity for phase in own])[which]
    columns = np.hstack([waves_at, waves_at * turning[:, None]])
    count = np.bincount(which)
    columns -= np.column_stack([np.bincount(which, column) / count for column in columns.T])[which]
    solved, _, rank, _ = np.linalg.lstsq(columns, force, rcond=1e-6)
    if rank < columns.shape[1]:
        raise LogError("the passes are too short to tell these wavenumbers apart; go over more of the stroke")
    noise = float(np.std(force - columns @ solved)) * COLOUR
    deviation = noise * np.sqrt(np.diag(np.linalg.inv(columns.T @ columns)))
    waves = []
    for k, wavenumber in enumerate(wavenumbers):
        pair, error = solved[2 * k : 2 * k + 2], deviation[2 * k : 2 * k + 2]
        if np.hypot(*pair) > max(least, SURE * float(np.max(error))):
            waves.append(Wave(wavenumber=float(wavenumber), cosine=float(pair[0]), sine=float(pair[1])))
    return tuple(waves)


def harmonics(period: float, count: int) -> Floats:
    """Return the first ``count`` wavenumbers, 1/m or 1/rad, of what repeats with a ``period`` along the stroke."""
    return np.asarray(2.0 * np.pi / period * np.arange(1, count + 1), dtype=np.float64)
