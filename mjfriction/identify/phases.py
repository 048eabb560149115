"""Phases of constant speed in a log: where one joint moves steadily and the others stand still."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mjfriction.record.log import Floats
from mjfriction.record.motion import Motion

STEADY = 0.05  # share of a phase's speed by which the speed may vary within it
STANDING = 0.02  # share of a joint's fastest speed, below which it stands still
SHORTEST = 0.1  # s
LEAST_PART = 0.4  # share of a pass that must have constant speed: a smooth move is fast only for a moment
LEAST_WAY = 1e-4  # share of the joint's stroke that a phase covers: simulated friction lets joints creep at their rests
SETTLED = 0.1  # s at both ends of a phase, in which filters still respond to the change of speed


@dataclass(frozen=True)
class Phase:
    """Samples ``first`` to ``past`` of a motion in which ``joint`` moves at a constant velocity, rad/s or m/s."""

    joint: int
    first: int
    past: int
    velocity: float


def constant_speed_phases(motion: Motion) -> list[Phase]:
    """Return the phases of constant speed in a motion, in order of time."""
    going = goes(motion)
    out = []
    for joint in np.flatnonzero(motion.moving).tolist():
        others = np.delete(going, joint, axis=1)
        free = ~np.any(others, axis=1)
        velocity = motion.velocity[:, joint]
        sure = free & (np.abs(velocity) > motion.resting_speed[joint])
        for first, past in _runs(sure, np.sign(velocity), motion.piece):
            phase = _steady_part(motion, joint, first, past)
            least = LEAST_WAY * float(np.ptp(motion.position[:, joint]))
            if phase is not None and abs(phase.velocity) * (phase.past - phase.first) > least * motion.rate:
                out.append(phase)
    return sorted(out, key=lambda phase: phase.first)


def goes(motion: Motion) -> NDArray[np.bool_]:
    """Return where each joint moves, rather than standing still or being held, (n, joints)."""
    top = np.where(motion.moving, np.max(np.abs(motion.velocity), axis=0), np.inf)
    return np.asarray(np.abs(motion.velocity) > np.maximum(motion.resting_speed, STANDING * top))


def _runs(mask: np.ndarray, sign: Floats, piece: np.ndarray) -> list[tuple[int, int]]:
    key = np.where(mask, sign, 0.0)
    cuts = np.flatnonzero((np.diff(key) != 0.0) | (np.diff(piece) != 0)) + 1
    return [(a, b) for a, b in itertools.pairwise([0, *cuts.tolist(), key.size]) if key[a] != 0.0]


def _steady_part(motion: Motion, joint: int, first: int, past: int) -> Phase | None:
    velocity = motion.velocity[first:past, joint]
    noise = float(motion.velocity_noise[joint])
    plateau = float(np.median(velocity[np.abs(velocity) > 0.9 * np.quantile(np.abs(velocity), 0.9)]))
    near = np.abs(velocity - plateau) < max(STEADY * abs(plateau), 3.0 * noise)
    # The longest stretch at the plateau, without what the filter blurs into it.
    cuts = np.flatnonzero(np.diff(near.astype(np.int8))) + 1
    stretches = [(a, b) for a, b in itertools.pairwise([0, *cuts.tolist(), near.size]) if near[a]]
    if not stretches:
        return None
    a, b = max(stretches, key=lambda stretch: stretch[1] - stretch[0])
    margin = int(max(SETTLED, 1.0 / motion.cutoff) * motion.rate)
    a, b = a + margin, b - margin
    if b - a < max(4.0, SHORTEST * motion.rate) or b - a < LEAST_PART * (past - first) - 2 * margin:
        return None
    return Phase(joint, first + a, first + b, float(np.mean(velocity[a:b])))
