"""The motion of a log without the jumps that its position sensors make across play (backlash)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from mjfriction.record.log import POSITION, VELOCITY, Floats, Log
from mjfriction.record.motion import Motion, back_to_log, estimate_motion, smooth_derivatives
from mjfriction.record.resample import onto_grid

# Share of the rate of change that the jumps add to the position; a measured velocity that contains more jumps as well.
JUMPS_TOO = 0.5


def without_jumps(log: Log, motion: Motion, plays: Mapping[int, tuple[float, Floats]]) -> Motion:
    """Return the motion of a log as it would be without the jumps of its position sensors.

    ``plays`` maps a joint to the size of its jumps (rad or m) and the course of
    :class:`~mjfriction.record.jumps.Jumps` along the ``motion``, which was estimated with the jumps.  A measured
    velocity that jumps as well is left out.
    """
    columns = dict(log.columns)
    for joint, (play, course) in plays.items():
        name = motion.joints[joint]
        jumped = 0.5 * play * course
        position, velocity = f"{POSITION}.{name}", f"{VELOCITY}.{name}"
        columns[position] = columns[position] - np.nan_to_num(back_to_log(motion, log, jumped))
        if velocity in columns and _jumps_too(on_clock(log, motion, velocity), motion, joint, jumped):
            del columns[velocity]
    cleared = estimate_motion(replace(log, columns=columns), motion.joints, motion.cutoff, motion.sliding)
    return replace(cleared, jump_free=frozenset(plays))


def _jumps_too(velocity: Floats, motion: Motion, joint: int, jumped: Floats) -> bool:
    # Whether a measured velocity contains most of what the jumps add to the position's rate of change.
    added = smooth_derivatives(motion, jumped)[1]
    rest = smooth_derivatives(motion, velocity)[0] - (motion.differentiated(motion.position[:, joint]) - added)
    return bool(rest @ added > JUMPS_TOO * (added @ added))


def on_clock(log: Log, motion: Motion, column: str) -> Floats:
    """Return a recorded column on a motion's clock, unfiltered, (n,)."""
    recorded = log.columns[column]
    return np.concatenate([onto_grid(recorded, log.time, grid, smooth=False) for grid in motion.grids])
