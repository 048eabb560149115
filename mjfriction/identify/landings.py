"""Landings of a link at the ends of its play: when it was released, when it landed, and how far it flew in between.

Where the load changes sign, a motor releases its link, which coasts across the play and lands with a blow.  How far it
flew follows from the effort it would have needed to stay with the motor, whatever effort was measured.  Where the
flights of many landings, slow and quick, are equally long, the joint has play.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mjfriction.record.load_turns import SLOW_LOAD
from mjfriction.record.log import Floats, Integers
from mjfriction.record.motion import Motion

TOGETHER = 0.06  # s, within which quick accelerations belong to one blow
RINGING = 1.0  # periods of the position filter's cutoff around a blow in which the load cannot be estimated
SHORTEST = 0.03  # s; a flight that is shorter cannot be resolved
FEWEST = 5  # landings
# Relative difference up to which two flights are equally long; share of all blows that must belong to such flights.
AGREE, MOSTLY = 0.2, 0.5
# Times the spread of the flights' lengths: by how much these would differ if they followed from the flights' durations
# alone.
VARIED = 2.0


@dataclass(frozen=True)
class Landings:
    """The play that the landings of a link show.

    ``play`` (rad or m) is how far the link flies between its stops, ``count`` the number of flights of that length.
    ``course`` (n,) is where the link is in its play along the motion, from −1 (ahead of the motor) to 1 (behind it).
    """

    play: float
    count: int
    course: Floats


def struck(blown: Floats, motion: Motion, inertia: Floats, joint: int) -> Integers:
    """Return the samples at which a joint's own blows occurred.

    ``blown`` (n, joints) are the accelerations of blows, ``inertia`` (n, joints) is the joint's row of the mass matrix:
    a blow that another joint passes on does not count.
    """
    own = inertia[:, joint] * blown[:, joint]
    at = np.flatnonzero(np.abs(own) > np.sum(np.abs(inertia * blown), axis=1) - np.abs(own))
    groups = np.split(at, np.flatnonzero(np.diff(at) > TOGETHER * motion.rate) + 1) if at.size else []
    return np.array([group[np.argmax(np.abs(own[group]))] for group in groups], dtype=np.intp)


def find_landings(motion: Motion, load: Floats, inertia: Floats, blown: Floats, joint: int) -> Landings | None:
    """Return the landings of a joint's link, None where its blows do not show play.

    ``load`` (n,) is the effort that the link would need to follow its motor, ``inertia`` (n, joints) the joint's row of
    the mass matrix, ``blown`` (n, joints) the accelerations of blows.
    """
    at = struck(blown, motion, inertia, joint)
    if at.size < FEWEST:
        return None
    pull = motion.low_passed(_unhidden(load, blown, motion), SLOW_LOAD * motion.cutoff) / inertia[:, joint]
    starts = np.flatnonzero((np.diff(np.sign(pull)) != 0.0) | (np.diff(motion.piece) != 0)) + 1
    starts = np.append(0, starts)
    begun = starts[np.searchsorted(starts, at, side="right") - 1]
    flown = np.array([_flight(pull, start, end, motion.rate)[-1] for start, end in zip(begun, at, strict=True)])
    # A link that lands behind its motor decelerates it, and the reverse.
    seen = (at - begun > SHORTEST * motion.rate) & (np.sign(flown) == -np.sign(blown[at, joint]))
    if np.sum(seen) < FEWEST:
        return None
    far, lasted = np.log(np.abs(flown[seen])), np.log((at - begun)[seen] / motion.rate)
    alike = np.abs(far[:, None] - far) < AGREE
    best = alike[np.argmax(np.sum(alike, axis=1))]
    count = int(np.sum(best))
    # Flights that all lasted equally long, from one motion repeated, are equally long whether there is play or not.
    varied = 3.0 * np.std(lasted[best]) > VARIED * np.std(far[best])
    if count < max(FEWEST, MOSTLY * at.size) or not varied:
        return None
    play = float(np.exp(np.median(far[best])))
    flights = list(zip(begun[seen][best].tolist(), at[seen][best].tolist(), strict=True))
    return Landings(play, count, _course(pull, motion, flights))


def _unhidden(load: Floats, blown: Floats, motion: Motion) -> Floats:
    # The load, interpolated over the samples where blows distort it.
    hidden = np.any(blown != 0.0, axis=1)
    reach = int(np.ceil(RINGING * motion.rate / motion.cutoff))
    hidden = np.convolve(hidden, np.ones(2 * reach + 1), mode="same") > 0.5
    if np.all(hidden):
        return load
    rows = np.arange(load.size)
    return np.interp(rows, rows[~hidden], load[~hidden])


def _flight(pull: Floats, start: int, end: int, rate: float) -> Floats:
    # How far a link falls behind its motor at each sample from ``start``, where it is released, to ``end``.  ``pull``
    # is the acceleration it would need to follow.
    return np.cumsum(np.cumsum(pull[start : end + 1])) / rate**2


def _course(pull: Floats, motion: Motion, flights: list[tuple[int, int]]) -> Floats:
    # In flight the link goes from stop to stop.  Between two flights it rests where it landed.  Where the next flight
    # begins at the other stop, the link went there slowly, without a blow that shows when.
    course = np.zeros_like(pull)
    for own in motion.pieces:
        inside = [flight for flight in flights if own.start <= flight[0] < own.stop]
        rested, stands = own.start, 0.0
        for begun, landed in inside:
            flown = _flight(pull, begun, landed, motion.rate)
            side = np.sign(flown[-1])
            course[rested:begun] = _slowly(stands or -side, -side, begun - rested)
            course[begun : landed + 1] = side * (2.0 * flown / flown[-1] - 1.0)
            rested, stands = landed + 1, side
        course[rested : own.stop] = stands
    return course


def _slowly(here: float, there: float, count: int) -> Floats:
    share = (np.arange(count) + 0.5) / max(count, 1)
    return np.asarray(here + (there - here) * share**2 * (3.0 - 2.0 * share))
