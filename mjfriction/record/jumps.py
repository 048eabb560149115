"""Jumps of a position sensor as the load on its transmission changes sign: play, seen in the position itself.

A sensor on the motor's side of a gear that has play moves by that play while the link stays where it is.  Where that
takes some milliseconds no link could have gone so far, whatever efforts say.
"""

from __future__ import annotations

import functools
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter1d
from scipy.special import ndtr
from scipy.stats import binom

from mjfriction.record.log import POSITION, VELOCITY, Floats, Integers, Log
from mjfriction.record.motion import Motion, back_to_log, estimate_motion, smooth_derivatives
from mjfriction.record.resample import onto_grid

WIDTHS = (0.0, 4e-3, 8e-3, 12e-3, 20e-3)  # s, deviations of the edges of jumps that are looked for
BEFORE, PER_WIDTH, FEWEST = 0.02, 4.0, 10  # s, widths and samples, on each side of a jump, that show the motion there
DEGREE = 5  # of the polynomial that the motion around a jump is
PLAIN = 8.0  # deviations of what the same filter makes of the motion elsewhere
NORMAL = 1.4826  # deviations of a normal distribution in its median absolute one
SLOW_LOAD = 0.2  # of the position filter's cutoff: the load, without what jumps themselves seem to accelerate
NEAR = 0.1  # s, within which the load as predicted changes sign when a jump says that it does
BY_CHANCE = 1e-6  # how likely it may be that as many lie there by chance
MOSTLY, OFTEN = 0.7, 0.3  # of the jumps that must lie there; of the load's changes of sign that must show one
NEARLY = 0.9  # of the jumps seen so far, with which a wider window is taken
FEWEST_ALIKE = 5  # jumps of one size
ALIKE = 0.3  # of their size, by which jumps of one play may differ
EDGES = (0.0, *np.geomspace(0.1, 1.6, 48))  # widths of an edge that are tried, times the one that was looked for
EDGE_KNOWN = 0.03  # of the size of a jump with a wide edge, that goes with the step between two of these
EARLIER = (-1.0, 1.0, 41)  # widths by which an edge is tried earlier and later
JUMPS_TOO = 0.5  # of what a jump adds to the rate of change, that a measured velocity has which jumps along
SURE = 1.96  # deviations, within which lies what is known at 95 %


@dataclass(frozen=True)
class Jumps:
    """Jumps of a joint's position sensor, ``size`` ± ``half_width`` (95 %) rad or m: ``course`` (n,), on the motion's
    clock, is where it stands, −1 to 1; ``count`` is how often it jumps, of ``crossings`` of the load.
    """

    size: float
    half_width: float
    course: Floats
    count: int
    crossings: int


@dataclass(frozen=True)
class _Edges:
    # Edges of a jump around the middle of a window: (edges, samples), each without what the motion could be, the
    # courses of the whole from 0 to 1 being those of times and widths, in samples.
    samples: Integers
    basis: Floats
    late: Floats
    width: Floats
    shape: Floats


def find_jumps(log: Log, motion: Motion, load: Floats) -> dict[int, Jumps]:
    """Return the jumps of position sensors, by joint, that come as the ``load`` (n, joints) there changes sign.

    A jump is what a polynomial through the motion around it leaves, far beyond what it leaves elsewhere.  That they
    come with the load must not be chance; they must be of one size, and most of all jumps there are.
    """
    slow = motion.low_passed(load, SLOW_LOAD * motion.cutoff)
    found = {}
    for joint in np.flatnonzero(motion.moving):
        jumps = _jumps_of(_on_clock(log, motion, f"{POSITION}.{motion.joints[joint]}"), motion, slow[:, joint])
        if jumps is not None:
            found[int(joint)] = jumps
    return found


def without_jumps(log: Log, motion: Motion, plays: Mapping[int, tuple[float, Floats]]) -> Motion:
    """Return the motion of a log as it would be had its position sensors not jumped.

    ``plays`` are, by joint, by how much they do (rad or m), and the ``course`` of :class:`Jumps` along the ``motion``
    that was estimated with the jumps.  A measured velocity that jumped along is left out.
    """
    columns = dict(log.columns)
    for joint, (play, course) in plays.items():
        name = motion.joints[joint]
        jumped = 0.5 * play * course
        position, velocity = f"{POSITION}.{name}", f"{VELOCITY}.{name}"
        columns[position] = columns[position] - np.nan_to_num(back_to_log(motion, log, jumped))
        if velocity in columns and _jumps_too(_on_clock(log, motion, velocity), motion, joint, jumped):
            del columns[velocity]
    cleared = estimate_motion(replace(log, columns=columns), motion.joints, motion.cutoff)
    return replace(cleared, jump_free=frozenset(plays))


def _jumps_too(velocity: Floats, motion: Motion, joint: int, jumped: Floats) -> bool:
    # Whether a measured velocity has most of what a jump of the position adds to its rate of change.
    added = smooth_derivatives(motion, jumped)[1]
    rest = smooth_derivatives(motion, velocity)[0] - (motion.differentiated(motion.position[:, joint]) - added)
    return bool(rest @ added > JUMPS_TOO * (added @ added))


def _on_clock(log: Log, motion: Motion, column: str) -> Floats:
    recorded = log.columns[column]
    return np.concatenate([onto_grid(recorded, log.time, grid, smooth=False) for grid in motion.grids])


def _jumps_of(position: Floats, motion: Motion, load: Floats) -> Jumps | None:
    crossings = np.flatnonzero((np.diff(np.sign(load)) != 0.0) & (np.diff(motion.piece) == 0)) + 1
    best = (0, 0.0, crossings, load)
    for width in WIDTHS:
        at, size = _steps(position, motion, width)
        there = _with_load(at, size, crossings, load, round(NEAR * motion.rate))
        # The widest window tells best how wide an edge is, and so how far it goes.
        if np.sum(there) > max(NEARLY * best[0], MOSTLY * there.size):
            best = int(np.sum(there)), width, at[there], size[there]
    count, width, at, size = best
    if count < max(FEWEST_ALIKE, OFTEN * crossings.size):
        return None
    return _measured(position, motion, width, at, np.sign(size), crossings.size)


def _steps(position: Floats, motion: Motion, width: float) -> tuple[Integers, Floats]:
    # Where the position steps beyond what it does elsewhere, as samples, and by how much.
    samples, basis = _window(motion.rate, width)
    step = _beside(_edge(samples, 0.0, width * motion.rate), basis)
    weights, reach = step / (step @ step), int(samples[-1])
    size = np.zeros_like(position)
    for own in motion.pieces:
        if np.count_nonzero(own) > samples.size:
            inner = np.flatnonzero(own)[reach:-reach]
            size[inner] = np.convolve(position[own], weights[::-1], mode="valid")
    height = np.abs(size)
    usual = NORMAL * np.median(height[height > 0.0]) if np.any(height) else 0.0
    at = np.flatnonzero((height == maximum_filter1d(height, samples.size)) & (height > PLAIN * usual))
    return at, size[at]


def _with_load(at: Integers, size: Floats, crossings: Integers, load: Floats, near: int) -> NDArray[np.bool_]:
    # Which steps come as the load changes sign, to the side it changes to; none if as many may by chance.
    to = np.sign(load[crossings])
    apart = np.abs(at[:, None] - crossings)
    there = np.any((apart <= near) & (to == np.sign(size)[:, None]), axis=1)
    reached = np.zeros(load.size, dtype=bool)
    for shift in range(-near, near + 1):
        reached[np.clip(crossings + shift, 0, load.size - 1)] = True
    likely = binom.sf(np.sum(there) - 1, at.size, 0.5 * np.mean(reached)) > BY_CHANCE
    return np.asarray(there & ~likely)


def _measured(
    position: Floats, motion: Motion, width: float, at: Integers, way: Floats, crossings: int
) -> Jumps | None:
    edges = _edges(motion.rate, width)
    parts = way[:, None] * _beside(position[at[:, None] + edges.samples], edges.basis)
    along = np.maximum(parts @ edges.shape.T, 0.0)
    weight = np.sum(np.square(edges.shape), axis=1)
    size = np.take_along_axis(along / weight, np.argmax(along**2 / weight, axis=1)[:, None], axis=1)[:, 0]
    play = float(np.median(size))
    alike = np.abs(size - play) < ALIKE * play
    if np.sum(alike) < max(FEWEST_ALIKE, MOSTLY * alike.size):
        return None
    play = float(np.median(size[alike]))
    nearest = np.argmin(play * weight - 2.0 * along, axis=1)
    course, count = np.zeros_like(position), 0
    for own in motion.pieces:
        rows = np.flatnonzero(own)
        inside = np.flatnonzero(alike & (at >= rows[0]) & (at <= rows[-1]))
        if inside.size:
            course[rows] = -way[inside[0]]
        stands = 0.0
        for k in inside:
            if way[k] != stands:  # two to one side: between them one was missed, and the sensor stands where it stood
                late, wide = edges.late[nearest[k]], edges.width[nearest[k]]
                course[rows] += 2.0 * way[k] * (_edge(rows - at[k], late, wide) + 0.5)
                stands, count = way[k], count + 1
    spread = float(np.std(size[alike], ddof=1) / np.sqrt(np.sum(alike)))
    edge = EDGE_KNOWN * play if np.median(edges.width[nearest[alike]]) > 0.0 else 0.0
    return Jumps(play, SURE * spread + edge, course, count, crossings)


@functools.lru_cache(maxsize=64)
def _window(rate: float, width: float) -> tuple[Integers, Floats]:
    # The samples around a jump, and an orthonormal basis of what the motion may be there.
    reach = max(FEWEST, int(np.ceil((BEFORE + PER_WIDTH * width) * rate)))
    samples = np.arange(-reach, reach + 1)
    return samples, np.linalg.qr((samples[:, None] / reach) ** np.arange(DEGREE + 1))[0]


@functools.lru_cache(maxsize=64)
def _edges(rate: float, width: float) -> _Edges:
    samples, basis = _window(rate, width)
    wide = max(width * rate, 2.0)
    tried = [(late, share * wide) for share in EDGES for late in wide * np.linspace(*EARLIER)]
    late, widths = np.array(tried).T
    shape = np.array([_beside(_edge(samples, *one), basis) for one in tried])
    return _Edges(samples, basis, late, widths, shape)


def _beside(values: Floats, basis: Floats) -> Floats:
    # What is left of values (..., samples) beside a basis.
    return np.asarray(values - (values @ basis) @ basis.T)


def _edge(samples: Integers, late: float, width: float) -> Floats:
    # A step from −1/2 to 1/2.
    if width == 0.0:
        return np.where(samples < late, -0.5, 0.5)
    return np.asarray(ndtr((samples - late) / width) - 0.5)
