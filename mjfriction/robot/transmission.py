"""How far a transmission lets its link lag behind the motor: give under load, and play."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mjfriction.laws.law import Floats
from mjfriction.record.motion import Motion, smooth_derivatives
from mjfriction.robot.schema import Transmission
from mjfriction.sim.ringing import ringing
from mjfriction.sim.stops import between_stops

FLIGHT_RATE = 1000.0  # Hz, at least, at which a flight is followed: it lands between two samples of most logs
LEAST_INERTIA = 1e-9  # kg·m² or kg
CROSSING_BAND = 0.05  # of the position filter's cutoff: where a load changes sign, jumps of the sensor hide it
LOAD_BAND = 0.2  # of the position filter's cutoff: a load holds accelerations, and what gives under it their noise


@dataclass(frozen=True)
class Link:
    """A link along a motion as its transmission feels it, (n,) each.

    ``carried`` is the load along the link's own motion, ``behind`` how far the motor's sensor is ahead of it there,
    ``following`` what it would need to follow the motor from where it is, ``inertia`` what it weighs, and ``stiffness``
    how its load grows with its position.
    """

    carried: Floats
    behind: Floats
    following: Floats
    inertia: Floats
    stiffness: Floats


def lag(own: Transmission, motion: Motion, link: Link) -> Floats:
    """Return how far the motor's sensor is ahead of a link along a motion, (n,), once it has followed what it feels."""
    if own.compliance > 0.0 and own.damping_ratio is not None:
        out = swinging(motion, link.following, link.inertia, own.compliance, own.damping_ratio)
    else:
        out = own.compliance * smooth_derivatives(motion, link.carried, LOAD_BAND)[0]
    if own.backlash > 0.0:
        at_motor = link.following + link.stiffness * link.behind
        place = (
            coasting(motion, at_motor, link.inertia, link.stiffness, own.backlash)
            if own.coasting
            else crossing(slow_load(motion, link.carried), own.crossing_load)
        )
        out = out + 0.5 * own.backlash * place
    return np.asarray(out)


def slow_load(motion: Motion, load: Floats) -> Floats:
    """Return a load (n,) without what a sensor that crosses play seems to accelerate."""
    return smooth_derivatives(motion, load, CROSSING_BAND)[0]


def crossing(load: Floats, within: float) -> Floats:
    """Return where a link is in play that its ``load`` (n,) crosses ``within`` some N·m or N, at once within none, from
    −1 (ahead of the motor) to 1 (behind it), (n,).
    """
    return np.asarray(np.tanh(load / within) if within > 0.0 else np.sign(load))


def natural_frequency(inertia: Floats, compliance: float | Floats) -> Floats:
    """Return the frequency (rad/s, (n,)) at which a link of an ``inertia`` (n,) swings on its transmission, the motor
    held; of compliances (k,) beside one another with inertia (n, 1), (n, k).
    """
    return 1.0 / np.sqrt(compliance * np.maximum(inertia, LEAST_INERTIA))


def swinging(
    motion: Motion, following: Floats, inertia: Floats, compliance: float | Floats, damping_ratio: float
) -> Floats:
    """Return how far a link that swings on its transmission is behind the motor, (n,).

    compliance·(inertia·s̈ + damping·ṡ) + s = compliance·following, damped by a share of what is critical, pieces apart.
    With many compliances (k,) beside one another, what else there is has shape (n, k), or one that spreads to it.
    """
    following, frequency = np.broadcast_arrays(following, natural_frequency(inertia, compliance))
    out = np.empty_like(following)
    finer = int(np.ceil(FLIGHT_RATE / motion.rate))
    for own in motion.pieces:
        step = 1.0 / (finer * motion.rate)
        out[own] = ringing(compliance * following[own], frequency[own], damping_ratio, step, finer)
    return out


def coasting(motion: Motion, at_motor: Floats, inertia: Floats, stiffness: Floats, backlash: float) -> Floats:
    """Return where the link is in its play, from −1 (ahead of the motor) to 1 (behind it), (n,).

    Where the load changes sign the motor lets go.  Until a stop takes it, the link moves on its own:
    inertia·s̈ = at_motor − stiffness·s, s being how far it is behind, ``at_motor`` what it would need where the motor
    is, moving as that does, and ``stiffness`` how that grows with its position; no stop throws it back.  A link that
    stands above its axis is let go only where the motor has taken it past its upright by half of the play.
    """
    out = np.empty_like(at_motor)
    pull, back = at_motor / inertia / (0.5 * backlash), stiffness / inertia
    finer = int(np.ceil(FLIGHT_RATE / motion.rate))
    step = 1.0 / (finer * motion.rate)
    for own in motion.pieces:
        out[own] = between_stops(pull[own], back[own], step, round(1.0 / (step * motion.cutoff)), finer)
    return out
