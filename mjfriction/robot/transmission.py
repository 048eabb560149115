"""How far the link lags behind the motor: the transmission's compliance under load, and play."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mjfriction.laws.law import Floats
from mjfriction.record.motion import Motion, smooth_derivatives
from mjfriction.robot.schema import Transmission
from mjfriction.sim.flanks import between_flanks
from mjfriction.sim.ringing import deflection, ringing
from mjfriction.sim.stops import between_stops

# Hz, usual integration rate for the link's motion in its play or on its compliance: the link crosses its play between
# two samples of most logs.
FLIGHT_RATE = 1000.0
LEAST_INERTIA = 1e-9  # kg·m² or kg, lower bound that keeps the natural frequency finite
# Cutoff of the load whose sign sets the place in the play, as a fraction of the position filter's cutoff: where the
# load changes sign, the sensor's own jumps would hide it.
CROSSING_BAND = 0.05
# Cutoff of the load that deflects the compliance, as a fraction of the position filter's cutoff: the load contains
# accelerations, and the deflection would contain their noise.
LOAD_BAND = 0.2


@dataclass(frozen=True)
class Link:
    """A link along a motion as its transmission sees it, (n,) each.

    ``carried`` is the load along the link's own motion, and ``behind`` is how far the link is behind the motor's sensor
    there.  ``following`` is the load it would have if it accelerated like the motor from its present position.
    ``inertia`` is the link's inertia, and ``stiffness`` is the derivative of its load with respect to its position.
    """

    carried: Floats
    behind: Floats
    following: Floats
    inertia: Floats
    stiffness: Floats


def lag(own: Transmission, motion: Motion, link: Link) -> Floats:
    """Return how far the motor's sensor is ahead of a link along a motion, (n,), by compliance and play."""
    if own.compliance > 0.0 and own.damping_ratio is not None:
        if own.backlash > 0.0 and own.coasting:
            flanks = (own.compliance, own.damping_ratio, 0.5 * own.backlash, own.hardening)
            return flying(motion, link.following, link.inertia, *flanks)
        out = swinging(motion, link.following, link.inertia, own.compliance, own.damping_ratio, own.hardening)
    else:
        straight = own.compliance * smooth_derivatives(motion, link.carried, LOAD_BAND)[0]
        out = deflection(straight, own.compliance * own.hardening)
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
    """Return a load (n,) low-passed so far that the apparent accelerations of a sensor crossing play are gone."""
    return smooth_derivatives(motion, load, CROSSING_BAND)[0]


def crossing(load: Floats, within: float) -> Floats:
    """Return where a link is in its play under a ``load`` (n,), from −1 (ahead of the motor) to 1 (behind it), (n,).

    The link crosses while the load passes through about ±``within`` (N·m or N), instantly if that is 0.
    """
    return np.asarray(np.tanh(load / within) if within > 0.0 else np.sign(load))


def natural_frequency(inertia: Floats, compliance: float | Floats) -> Floats:
    """Return the natural frequency (rad/s, (n,)) of a link of ``inertia`` (n,) on its compliance with the motor held.

    Several compliances (k,) with an inertia of shape (n, 1) give (n, k).
    """
    return 1.0 / np.sqrt(compliance * np.maximum(inertia, LEAST_INERTIA))


def swinging(
    motion: Motion,
    following: Floats,
    inertia: Floats,
    compliance: float | Floats,
    damping_ratio: float,
    hardening: float | Floats = 0.0,
    rate: float = FLIGHT_RATE,
) -> Floats:
    """Return how far a link that oscillates on its transmission is behind the motor, (n,).

    Solves inertia·s̈ + damping·ṡ + s/compliance + hardening·s³ = following for each piece of the motion separately, at
    a ``rate`` (Hz) or more; ``damping_ratio`` is relative to critical damping near s = 0.  For several compliances and
    hardenings (k,) at once, the other arrays have shape (n, k) or one that broadcasts to it.
    """
    following, frequency = np.broadcast_arrays(following, natural_frequency(inertia, compliance))
    out = np.empty_like(following)
    finer = int(np.ceil(rate / motion.rate))
    for own in motion.pieces:
        step = 1.0 / (finer * motion.rate)
        aim = compliance * following[own]
        out[own] = ringing(aim, frequency[own], damping_ratio, step, finer, compliance * hardening)
    return out


def flying(
    motion: Motion,
    following: Floats,
    inertia: Floats,
    compliance: float | Floats,
    damping_ratio: float,
    half: float | Floats,
    hardening: float = 0.0,
) -> Floats:
    """Return how far a link is behind the motor that flies within its play and swings on flanks that give, (n,).

    As :func:`swinging`, but the spring acts beyond ±``half`` the play only.
    """
    following, frequency = np.broadcast_arrays(following, natural_frequency(inertia, compliance))
    aim, rate = ((compliance * following).reshape(following.shape[0], -1), frequency.reshape(following.shape[0], -1))
    halves = np.array(np.broadcast_to(half, aim.shape[1:]), dtype=np.float64)
    out, finer, hard = np.empty_like(aim), int(np.ceil(FLIGHT_RATE / motion.rate)), compliance * hardening
    for own in motion.pieces:
        step = 1.0 / (finer * motion.rate)
        out[own] = between_flanks(aim[own], rate[own], halves, damping_ratio, step, finer, hard)
    return out.reshape(following.shape)


def coasting(motion: Motion, at_motor: Floats, inertia: Floats, stiffness: Floats, backlash: float) -> Floats:
    """Return where the link is in its play, from −1 (ahead of the motor) to 1 (behind it), (n,).

    The link leaves its stop where the load changes sign.  Until it reaches a stop, it moves freely:
    inertia·s̈ = at_motor − stiffness·s.  Here s is how far it is behind the motor, ``at_motor`` is the load it would
    have at the motor's position, moving as the motor does, and ``stiffness`` is the derivative of that load with
    respect to position.  It does not bounce off a stop.  A link that stands above its axis leaves its stop only after
    the motor has moved it past its upright by half of the play.
    """
    out = np.empty_like(at_motor)
    pull, back = at_motor / inertia / (0.5 * backlash), stiffness / inertia
    finer = int(np.ceil(FLIGHT_RATE / motion.rate))
    step = 1.0 / (finer * motion.rate)
    for own in motion.pieces:
        out[own] = between_stops(pull[own], back[own], step, round(1.0 / (step * motion.cutoff)), finer)
    return out
