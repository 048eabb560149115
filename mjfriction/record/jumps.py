"""Jumps of a position sensor as the load on its transmission changes sign: play (backlash) seen in the position itself.

A sensor on the motor's side of a gear with play moves by that play while the link stays where it is.  Where this takes
only some milliseconds, no link could have moved so far, whatever the efforts are.
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

WIDTHS = (0.0, 4e-3, 8e-3, 12e-3, 20e-3)  # s, standard deviations of the jumps' edges that are searched for
# Half a window around a jump: BEFORE (s) plus PER_WIDTH edge widths, and FEWEST samples at least.
BEFORE, PER_WIDTH, FEWEST = 0.02, 4.0, 10
DEGREE = 5  # of the polynomial that stands for the motion around a jump
PLAIN = 8.0  # a step must exceed this many standard deviations of the filter's output along the motion
NORMAL = 1.4826  # a normal distribution's standard deviation over its median absolute deviation
BY_CHANCE = 1e-6  # highest probability that as many jumps meet turns of the load by chance
# Shares of the jumps that must meet a turn of the load: SOME with the load along the motion that contains the jumps,
# MOSTLY with the load along the motion without them.  MOSTLY is also the share that must be of one size.
SOME, MOSTLY = 0.5, 0.7
OFTEN = 0.5  # share of the load's turns that must show a jump
NEARLY = 0.9  # a wider edge is preferred if it still finds more than this share of the jumps found so far
FEWEST_ALIKE = 3  # jumps of one size
FEWEST_STEPS = 12  # steps that are examined even if they meet no turn of the load
LARGE = 0.5  # of the size of the jumps that meet turns; smaller steps are not examined
ALIKE = 0.3  # of their median size; jumps that differ from it by less are of one play
# Share of what jumps leave of a polynomial fit, squared, that may be no step, beyond what is left elsewhere: a link
# that flies across its play for a while moves its sensor too, but not in one step.
NO_STEP = 0.05
EDGES = (0.0, *np.geomspace(0.1, 1.6, 48))  # edge widths that are tried, as multiples of the width searched for
EDGE_KNOWN = 0.03  # uncertainty from the grid of EDGES, as a share of the size of a jump with a wide edge
EARLIER = (-1.0, 1.0, 41)  # edge widths: first and last time shift that is tried, and how many
SURE = 1.96  # standard deviations of a 95 % interval


@dataclass(frozen=True)
class Jumps:
    """Jumps of a joint's position sensor, ``size`` ± ``half_width`` (95 %) in rad or m.

    ``course`` (n,), on the motion's clock, is the side at which the sensor stands, −1 to 1.  It jumps ``at`` these
    samples, (jumps,), in the direction ``way``, −1 or 1, (jumps,).  ``turns`` is the number of the load's turns.
    """

    size: float
    half_width: float
    course: Floats
    at: Integers
    way: Floats
    turns: int

    @property
    def count(self) -> int:
        """The number of jumps."""
        return self.at.size


@dataclass(frozen=True)
class _Edges:
    # Candidate edges of a jump in a window of samples: the time shift ``late`` and the ``width`` of each, in samples,
    # and its ``shape`` (edges, samples), a step of 1 without its projection on the ``basis`` of the motion.
    samples: Integers
    basis: Floats
    late: Floats
    width: Floats
    shape: Floats


def find_jumps(log: Log, motion: Motion, load_along: Callable[[Motion], Floats]) -> dict[int, Jumps]:
    """Return the jumps of position sensors, by joint, that occur as the load on the joint changes sign.

    A jump is a residual of a polynomial fit to the motion around it that far exceeds the residuals elsewhere.
    The jumps must be steps, of one size, must meet the load's turns more often than by chance, and must be most of all
    jumps found.  ``load_along`` returns the load (n, joints) along a motion.  It is called first with the given motion,
    whose acceleration contains the jumps, then with the motion without them.
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
        # The widest window determines the width of an edge best, and so the size of the jump.
        if count > max(NEARLY * before, SOME * met.size) and turns.chance(met) < BY_CHANCE:
            best = count, width, at, np.sign(size)
        if steps[0].size >= max(FEWEST_STEPS, NEARLY * (by_themselves[0] if by_themselves else 0)):
            by_themselves = steps[0].size, width, steps[0], np.sign(steps[1])
    # Jumps whose apparent acceleration exceeds that of the motion reverse the load's turns, so that few meet.  Such
    # steps are measured and taken off first, and checked against the load afterwards.
    best = best or by_themselves
    return None if best is None else _measured(position, motion, turns.count, *best[1:])


def _steps(position: Floats, motion: Motion, width: float) -> tuple[Integers, Floats]:
    # The samples at which the position steps by more than it does elsewhere, and the sizes of the steps.
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
    # The steps about as large as those that meet the load's turns: a far smaller one is no jump of the same play.
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
    power = np.sum(np.square(parts[alike]), axis=1)
    left = power - np.max(along[alike] ** 2 / weight, axis=1)
    usual, by_chance = _usually_left(position, motion, edges)
    if np.median(left) > usual + SURE * by_chance / np.sqrt(left.size) + NO_STEP * np.median(power):
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
            if way[k] != stands:  # a second jump to one side means that one between was missed; the sensor stays there
                late, wide = edges.late[nearest[k]], edges.width[nearest[k]]
                course[own] += 2.0 * way[k] * (_edge(rows - at[k], late, wide) + 0.5)
                stands = way[k]
                taken.append(k)
    spread = float(np.std(size[alike], ddof=1) / np.sqrt(np.sum(alike)))
    edge = EDGE_KNOWN * play if np.median(edges.width[nearest[alike]]) > 0.0 else 0.0
    return Jumps(play, SURE * spread + edge, course, at[taken], way[taken], turns)


def _usually_left(position: Floats, motion: Motion, edges: _Edges) -> tuple[float, float]:
    # The squares that noise, and motion that is no polynomial, usually leave in a window, and their spread by chance.
    reach = int(edges.samples[-1])
    centres = [np.arange(own.start + reach, own.stop - reach, reach) for own in motion.pieces]
    left = _beside(position[np.concatenate(centres)[:, None] + edges.samples], edges.basis)
    usual = float(np.median(np.sum(np.square(left), axis=1)))
    return usual, usual * float(np.sqrt(2.0 / (edges.samples.size - DEGREE - 1)))


@functools.lru_cache(maxsize=64)
def _window(rate: float, width: float) -> tuple[Integers, Floats]:
    # The samples around a jump, and an orthonormal basis of the polynomials that the motion may be there.
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
    # Values (..., samples) without their projection on a basis.
    return np.asarray(values - (values @ basis) @ basis.T)


def _edge(samples: Integers, late: float, width: float) -> Floats:
    # A step from −1/2 to 1/2.
    if width == 0.0:
        return np.where(samples < late, -0.5, 0.5)
    return np.asarray(ndtr((samples - late) / width) - 0.5)
