"""How far a transmission lets its link lag behind the motor: give under load, and play."""

from __future__ import annotations

import numpy as np

from mjfriction.laws.law import Floats
from mjfriction.record.motion import Motion, smooth_derivatives
from mjfriction.robot.schema import Transmission

LOAD_BAND = 0.2  # of the position filter's cutoff: a load holds accelerations, and what gives under it their noise
LONGEST_FLIGHT = 1.0  # s; a link that takes longer to cross its play is held by something else


def lag(own: Transmission, motion: Motion, load: Floats, inertia: Floats) -> Floats:
    """Return how far the motor's sensor is ahead of the link along a motion, (n,).

    ``load`` (n,) is what the link needs to follow the motor, ``inertia`` (n,) what it weighs.
    """
    out = own.compliance * smooth_derivatives(motion, load, LOAD_BAND)[0]
    if own.backlash > 0.0:
        crossing = coasting(motion, load, inertia, own.backlash) if own.coasting else np.sign(load)
        out = out + 0.5 * own.backlash * crossing
    return np.asarray(out)


def coasting(motion: Motion, load: Floats, inertia: Floats, backlash: float) -> Floats:
    """Return where the link is in its play, from −1 (ahead of the motor) to 1 (behind it), (n,).

    Where the load changes sign the motor lets go.  Until the other stop takes it, the link moves on its own:
    inertia·s̈ = load, s being how far it is behind.
    """
    out = np.empty_like(load)
    step = 1.0 / motion.rate
    longest = int(LONGEST_FLIGHT * motion.rate)
    for piece in motion.pieces:
        own = np.flatnonzero(piece)
        pull, where = load[own] / inertia[own], np.sign(load[own])
        turns = np.flatnonzero(np.diff(where) != 0) + 1
        course, landed = np.repeat(where[:1], where.size), 0
        for turn in turns.tolist():
            if turn < landed:
                continue
            end = min(turn + longest, where.size)
            flight = course[turn - 1] + np.cumsum(np.cumsum(pull[turn:end])) * step**2 / (0.5 * backlash)
            over = np.flatnonzero(np.abs(flight) >= 1.0)
            # The stop it left carries it until it really leaves; small ripples of load bring it back there.
            stop = int(over[over > 0][0]) if np.any(over > 0) else flight.size
            course[turn : turn + stop] = np.clip(flight[:stop], -1.0, 1.0)
            landed = turn + stop
            course[landed:] = np.sign(flight[stop]) if stop < flight.size else where[min(landed, where.size - 1)]
        out[own] = course
    return out
