"""Jumps of a position sensor as the load on its transmission changes sign: play, seen in the position itself.

A sensor on the motor's side of a gear that has play moves by that play while the link stays where it is.  Where that
takes some milliseconds no link could have gone so far, whatever efforts say.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import maximum_filter1d
from scipy.special import ndtr

from mjfriction.record.jump_free import on_clock, without_jumps
from mjfriction.record.load_turns import LoadTurns, load_turns
from mjfriction.record.log import POSITION, Floats, Integers, Log
from mjfriction.record.motion import Motion

WIDTHS = (0.0, 4e-3, 8e-3, 12e-3, 20e-3)  # s, deviations of the edges of jumps that are looked for
BEFORE, PER_WIDTH, FEWEST = 0.02, 4.0, 10  # s, widths and samples, on each side of a jump, that show the motion there
DEGREE = 5  # of the polynomial that the motion around a jump is
PLAIN = 8.0  # deviations of what the same filter makes of the motion elsewhere
NORMAL = 1.4826  # deviations of a normal distribution in its median absolute one
BY_CHANCE = 1e-6  # how likely it may be that as many lie there by chance
SOME, MOSTLY = 0.5, 0.7  # of the jumps, that must lie there; the load taken along the motion with and without them
OFTEN = 0.5  # of the load's turns, that must show one
NEARLY = 0.9  # of the jumps seen so far, with which a wider window is taken
FEWEST_ALIKE = 3  # jumps of one size
FEWEST_STEPS = 12  # alike, that are looked at though no load is known that turns with them
LARGE = 0.5  # of the jumps with the load, that a step must reach to be looked at
ALIKE = 0.3  # of their size, by which jumps of one play may differ
EDGES = (0.0, *np.geomspace(0.1, 1.6, 48))  # widths of an edge that are tried, times the one that was looked for
EDGE_KNOWN = 0.03  # of the size of a jump with a wide edge, that goes with the step between two of these
EARLIER = (-1.0, 1.0, 41)  # widths by which an edge is tried earlier and later
SURE = 1.96  # deviations, within which lies what is known at 95 %


@dataclass(frozen=True)
class Jumps:
    """Jumps of a joint's position sensor, ``size`` ± ``half_width`` (95 %) rad or m: ``course`` (n,), on the motion's
    clock, is where it stands, −1 to 1.  It jumps ``at`` some samples, to one ``way``, −1 or 1, or the other, (jumps,)
    each; the load has so many ``turns``.
    """

    size: float
    half_width: float
    course: Floats
    at: Integers
    way: Floats
    turns: int

    @property
    def count(self) -> int:
        """How often it jumps."""
        return self.at.size


@dataclass(frozen=True)
class _Edges:
    # Edges of a jump around the middle of a window: (edges, samples), each without what the motion could be, the
    # courses of the whole from 0 to 1 being those of times and widths, in samples.
    samples: Integers
    basis: Floats
    late: Floats
    width: Floats
    shape: Floats


def find_jumps(log: Log, motion: Motion, load_along: Callable[[Motion], Floats]) -> dict[int, Jumps]:
    """Return the jumps of position sensors, by joint, that come as the load on the joint changes sign.

    A jump is what a polynomial through the motion around it leaves, far beyond what it leaves elsewhere.  That they
    come with the load must not be chance; they must be of one size, and most of all jumps there are.  The load (n,
    joints) is asked for along a motion: first along the one there is, which jumps accelerate, then without them.
    """
    load = load_along(motion)
    found = {}
    for joint in np.flatnonzero(motion.moving).tolist():
        position = on_clock(log, motion, f"{POSITION}.{motion.joints[joint]}")
        jumps = _jumps_of(position, motion, load_turns(motion, load[:, joint]))
        if jumps is not None:
            found[joint] = jumps
    if not found:
        return found
    cleared = without_jumps(log, motion, {joint: (jumps.size, jumps.course) for joint, jumps in found.items()})
    load = load_along(cleared)
    turns = {joint: load_turns(cleared, load[:, joint]) for joint in found}
    return {
        joint: replace(jumps, turns=turns[joint].count) for joint, jumps in found.items() if _sure(jumps, turns[joint])
    }


def _sure(jumps: Jumps, turns: LoadTurns) -> bool:
    met = turns.meet(jumps.at, jumps.way)
    many = np.sum(met) > max(MOSTLY * met.size, OFTEN * turns.count)
    return bool(many and turns.chance(met) < BY_CHANCE)


def _jumps_of(position: Floats, motion: Motion, turns: LoadTurns) -> Jumps | None:
    best: tuple[int, float, Integers, Floats] | None = None
    by_themselves: tuple[int, float, Integers, Floats] | None = None
    for width in WIDTHS:
        steps = _steps(position, motion, width)
        at, size = _large(*steps, turns)
        met = turns.meet(at, size)
        count, before = int(np.sum(met)), 0 if best is None else best[0]
        # The widest window tells best how wide an edge is, and so how far it goes.
        if count > max(NEARLY * before, SOME * met.size) and turns.chance(met) < BY_CHANCE:
            best = count, width, at, np.sign(size)
        if steps[0].size >= max(FEWEST_STEPS, NEARLY * (by_themselves[0] if by_themselves else 0)):
            by_themselves = steps[0].size, width, steps[0], np.sign(steps[1])
    # Jumps that accelerate more than the motion does make the load turn the other way: they are taken off first.
    best = best or by_themselves
    return None if best is None else _measured(position, motion, turns.count, *best[1:])


def _steps(position: Floats, motion: Motion, width: float) -> tuple[Integers, Floats]:
    # Where the position steps beyond what it does elsewhere, as samples, and by how much.
    samples, basis = _window(motion.rate, width)
    step = _beside(_edge(samples, 0.0, width * motion.rate), basis)
    weights, reach = step / (step @ step), int(samples[-1])
    size = np.zeros_like(position)
    for own in motion.pieces:
        if own.stop - own.start > samples.size:
            size[own.start + reach : own.stop - reach] = np.convolve(position[own], weights[::-1], mode="valid")
    height = np.abs(size)
    usual = NORMAL * np.median(height[height > 0.0]) if np.any(height) else 0.0
    at = np.flatnonzero((height == maximum_filter1d(height, samples.size)) & (height > PLAIN * usual))
    return at, size[at]


def _large(at: Integers, size: Floats, turns: LoadTurns) -> tuple[Integers, Floats]:
    # The steps as large as those that come with the load: what is far smaller is no jump of the same play.
    there = np.sort(np.abs(size[turns.meet(at, size)]))
    large = np.abs(size) > (LARGE * there[-FEWEST_ALIKE] if there.size >= FEWEST_ALIKE else np.inf)
    return at[large], size[large]


def _measured(position: Floats, motion: Motion, turns: int, width: float, at: Integers, way: Floats) -> Jumps | None:
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
    course, taken = np.zeros_like(position), []
    for own in motion.pieces:
        rows = np.arange(own.start, own.stop)
        inside = np.flatnonzero(alike & (at >= own.start) & (at < own.stop))
        if inside.size:
            course[own] = -way[inside[0]]
        stands = 0.0
        for k in inside:
            if way[k] != stands:  # two to one side: between them one was missed, and the sensor stands where it stood
                late, wide = edges.late[nearest[k]], edges.width[nearest[k]]
                course[own] += 2.0 * way[k] * (_edge(rows - at[k], late, wide) + 0.5)
                stands = way[k]
                taken.append(k)
    spread = float(np.std(size[alike], ddof=1) / np.sqrt(np.sum(alike)))
    edge = EDGE_KNOWN * play if np.median(edges.width[nearest[alike]]) > 0.0 else 0.0
    return Jumps(play, SURE * spread + edge, course, at[taken], way[taken], turns)


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
