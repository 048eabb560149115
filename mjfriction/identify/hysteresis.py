"""What friction does before it slides: Maxwell-slip elements from slow turns, by bounded linear least squares.

An element of stiffness kᵢ that breaks away after a travel uᵢ gives kᵢ·Sᵢ(x), where Sᵢ is the play of a spring of unit
stiffness that slips at ±uᵢ.  With the travels on a fixed ladder the force is linear in the stiffnesses, kᵢ ≥ 0
(Lampaert, Swevers, Al-Bender, and others, pre-sliding compensation, section IV.A).  The number of elements is the
smallest that predicts held-out turns nearly as well as any.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import nnls

from mjfriction.errors import LogError
from mjfriction.laws.ambient import ambient
from mjfriction.laws.law import Floats
from mjfriction.laws.maxwell_slip import MAXWELL_SLIP

COUNTS = (1, 2, 3, 4, 6, 8, 12, 16)
SHORTEST = 0.01  # first travel of the ladder, as a share of the largest turn
FEWEST_TURNS = 4  # half cycles, so that some can be left out
AS_GOOD = 1.02  # times the least held-out error, up to which fewer elements are taken
FOLLOWS = 0.99  # share of the force's deviation that the residual must stay below
LEAST_SHARE = 1e-6  # share of the whole stiffness, below which an element is dropped


@dataclass(frozen=True)
class Elements:
    """Maxwell-slip elements fitted to a force.

    ``stiffness`` and breakaway ``travel`` of each (N,); the force's ``zero``; the RMS ``heldout`` on turns not fitted,
    for every number of elements tried; and the RMS ``left`` on all turns.
    """

    stiffness: Floats
    travel: Floats
    zero: float
    heldout: dict[int, float]
    left: float

    @property
    def level(self) -> Floats:
        """The force at which each slips, (N,)."""
        return self.stiffness * self.travel


def elements_of(position: Floats, force: Floats, counts: Sequence[int] = COUNTS) -> Elements:
    """Return the elements that reproduce the loops of ``force`` over ``position``, (n,) each, in order of time.

    What came before the first of the largest turns is left out: that turn erases whatever the elements remembered.
    Raises :class:`LogError` for a motion of fewer than four half turns, values that are not finite, or a force that
    does not follow the turns.
    """
    if not (np.all(np.isfinite(position)) and np.all(np.isfinite(force))):
        raise LogError("position and force must all be finite numbers; leave out the rows that are not")
    turns = _turns(position)
    if turns.size - 1 < FEWEST_TURNS:
        raise LogError(
            f"{max(turns.size - 1, 0)} half turns are too few to tell elements by; plan --protocol sawtooth makes more"
        )
    half = 0.5 * float(np.ptp(position[turns[0] :]))
    own = np.searchsorted(turns, np.arange(position.size), side="right") - 1
    rows = own >= 0
    held = {}
    for count in counts:
        stops = _stops(position, _ladder(half, count))
        errors = np.zeros(position.size)
        for out in (0, 1):
            # Whole cycles alternate between the folds, so that each has turns up and down.
            fold = rows & ((own // 2) % 2 == out)
            kept = rows & ~fold
            strengths = _bounded(stops[kept], force[kept])
            errors[fold] = force[fold] - stops[fold] @ strengths[:-1] - strengths[-1]
        held[count] = float(np.sqrt(np.mean(np.square(errors[rows]))))
    best = min(held.values())
    count = min(count for count, error in held.items() if error <= AS_GOOD * best)
    ladder = _ladder(half, count)
    stops = _stops(position, ladder)
    strengths = _bounded(stops[rows], force[rows])
    left = force[rows] - stops[rows] @ strengths[:-1] - strengths[-1]
    there = strengths[:-1] > LEAST_SHARE * np.sum(strengths[:-1])
    if not np.std(left) < FOLLOWS * np.std(force[rows]):
        raise LogError("the force does not follow the turns at all: no element has a stiffness; record smaller turns")
    return Elements(
        strengths[:-1][there], ladder[there], float(strengths[-1]), held, float(np.sqrt(np.mean(np.square(left))))
    )


def bristle_travel(position: Floats, velocity: Floats, force: Floats, level: Floats, exponent: float) -> Floats:
    """Return the Leuven law's z (n,) along a motion: dz = dx·(1 − sgn r·|r|^δ), r = force·sgn(v)/s(v), s the ``level``.

    The measured force stands for F_h(z), which it equals at slow turns, so that position is converted before any
    element is known.  The document names this way as the better one and leaves it open.
    """
    ratio = np.clip(force * np.sign(velocity) / level, -2.0, 2.0)
    share = 1.0 - np.sign(ratio) * np.abs(ratio) ** exponent
    change = np.diff(position) * 0.5 * (share[1:] + share[:-1])
    return np.concatenate([[0.0], np.cumsum(change)])


def _turns(position: Floats) -> np.ndarray:
    # Where the motion turns back, starting with the first of the largest excursions.
    reach = float(np.ptp(position))
    turns, last, way = [], 0, 0
    for i in range(1, position.size):
        if (way >= 0 and position[i] > position[last]) or (way <= 0 and position[i] < position[last]):
            way = 1 if position[i] > position[last] else -1
            last = i
        elif abs(position[i] - position[last]) > 0.05 * reach:
            turns.append(last)
            way, last = -way, i
    far = [
        k for k, i in enumerate(turns) if abs(position[i] - np.mean([position.max(), position.min()])) > 0.45 * reach
    ]
    return np.array([*turns[far[0] :], position.size - 1] if far else [])


def _ladder(half: float, count: int) -> Floats:
    # Breakaway travels.  The last never slips within the turns seen: it is the stiffness that is left at their ends.
    return np.geomspace(SHORTEST * half, 2.0 * half, count) if count > 1 else np.array([half])


def _stops(position: Floats, travels: Floats) -> Floats:
    # The law itself, with unit stiffness and levels equal to the travels: its states are then the plays.
    packed = MAXWELL_SLIP.pack({"viscous": 0.0, "stiffness": [1.0] * travels.size, "level": travels.tolist()})
    steps = np.diff(position, prepend=position[0])
    return MAXWELL_SLIP.follow(steps, ambient(position.size), 1.0, packed)[1]


def _bounded(stops: Floats, force: Floats) -> Floats:
    # Non-negative stiffnesses, and an offset of either sign as two columns, one of which stays at zero.
    columns = np.column_stack([stops, np.ones(force.size), -np.ones(force.size)])
    size = np.maximum(np.sqrt(np.mean(np.square(columns), axis=0)), 1e-300)
    # The triangular factor has only as many rows as there are columns, however long the log is.
    root = np.asarray(np.linalg.qr(np.column_stack([columns / size, force]), mode="r"))
    found = nnls(root[:-1, :-1], root[:-1, -1])[0] / size
    return np.append(found[:-2], found[-2] - found[-1])
