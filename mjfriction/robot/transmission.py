"""How far the link lags behind the motor: the transmission's compliance under load, and play."""

from __future__ import annotations

import numpy as np

from mjfriction.laws.law import Floats
from mjfriction.record.motion import Motion, smooth_derivatives
from mjfriction.robot.schema import Transmission
from mjfriction.sim.flanks import between_flanks
from mjfriction.sim.lagging import Lagging
from mjfriction.sim.ringing import at_rest, deflection, ringing
from mjfriction.sim.stops import between_stops

# Hz, usual integration rate for the link's motion in its play or on its compliance: the link crosses its play between
# two samples of most logs.
FLIGHT_RATE = 1000.0
# Share of a spring's stiffness that a link's weight takes off it at most: one that it outweighs would topple.
MOST_WEIGHT = 0.9
BEGINNING = 4.0  # s, of a piece of motion, from which it is told how a link swings at its beginning
FEWEST_SEEN = 8  # samples of these
LEAST_SWING = 1e-9  # ridge that keeps the fit of a swing which is over at once, relative to all columns
LEAST_INERTIA = 1e-9  # kg·m² or kg, lower bound that keeps the natural frequency finite
# Cutoff of the load whose sign sets the place in the play, as a fraction of the position filter's cutoff: where the
# load changes sign, the sensor's own jumps would hide it.
CROSSING_BAND = 0.05
# Cutoff of the load that deflects the compliance, as a fraction of the position filter's cutoff: the load contains
# accelerations, and the deflection would contain their noise.
LOAD_BAND = 0.2


def lag(own: Transmission, motion: Motion, carried: Floats, link: Lagging) -> Floats:
    """Return how far the motor's sensor is ahead of a link along a motion, (n,), by compliance and play.

    ``carried`` (n,) is the load along the link's own motion, and ``link`` what it carries where it lags its motor.
    """
    if own.swings and own.damping_ratio is not None:
        spring, damper = 1.0 / own.compliance, damper_of(link.inertia, own.compliance, own.damping_ratio)
        if own.backlash > 0.0 and own.coasting:
            return flying(motion, link, 0.5 * own.backlash, spring, damper, own.hardening)[:, 0]
        out = swinging(motion, link, spring, damper, own.hardening)[:, 0]
    else:
        straight = own.compliance * smooth_derivatives(motion, carried, LOAD_BAND)[0]
        out = deflection(straight, own.compliance * own.hardening)
    if own.backlash > 0.0:
        place = (
            coasting(motion, link, own.backlash)
            if own.coasting
            else crossing(slow_load(motion, carried), own.crossing_load)
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


def natural_frequency(inertia: Floats, compliance: float) -> Floats:
    """Return the natural frequencies (rad/s, (n,)) of a link of ``inertia`` (n,) while its motor is held."""
    return 1.0 / np.sqrt(compliance * np.maximum(inertia, LEAST_INERTIA))


def damper_of(inertia: Floats, compliance: float | Floats, damping_ratio: float | Floats) -> Floats:
    """Return the damping (N·m·s/rad or N·s/m) of a transmission, () or (k,) for several.

    ``damping_ratio`` is relative to critical damping at the usual one of the link's ``inertia`` along a motion (n,): a
    transmission's damping does not change with the pose.
    """
    usual = max(float(np.median(inertia)), LEAST_INERTIA)
    return np.asarray(2.0 * damping_ratio * np.sqrt(usual / compliance))


def swinging(
    motion: Motion,
    link: Lagging,
    spring: float | Floats,
    damper: float | Floats,
    hardening: float | Floats = 0.0,
    rate: float = FLIGHT_RATE,
) -> Floats:
    """Return how far a link that oscillates on its transmission is behind the motor, (n, k) for k transmissions.

    ``spring`` is the stiffness near s = 0, ``damper`` the damping and ``hardening`` the coefficient of s³, () or (k,)
    each.  Every piece of the motion is integrated by itself, at a ``rate`` (Hz) or more.
    """
    springs, dampers, hard = np.broadcast_arrays(np.atleast_1d(spring), damper, hardening)
    (finer, step), parts = _steps(motion, rate), []
    for own in motion.pieces:
        piece = link.over(own)
        piece = piece._replace(stiffness=np.maximum(piece.stiffness, -MOST_WEIGHT * np.min(springs)))
        begin = begun(piece.over(slice(round(BEGINNING * motion.rate))), springs, dampers, step, finer, hard)
        parts.append(ringing(piece, springs, dampers, step, finer, hard, begin))
    return np.concatenate(parts)


def begun(link: Lagging, spring: Floats, damper: Floats, step: float, finer: int, hardening: Floats) -> Floats:
    """Return how far a link lags, and how fast, at its first sample, for each of k transmissions, (2, k).

    A log may begin while the link swings, and one that is hardly damped does so for long.  That shows in what its drive
    was seen to pass on to it: the lag is fitted to that, by where and how fast it begins, beside what is slow (a
    straight line).  Where nothing was seen at first, as while the joint rests, it begins at rest.
    """
    begin = at_rest(link, spring, hardening)
    seen = np.full_like(link.load, np.nan) if link.seen is None else link.seen
    known = np.isfinite(seen)
    if np.count_nonzero(known[:FEWEST_SEEN]) < FEWEST_SEEN:
        return begin
    left = deflection(np.nan_to_num(seen)[:, None] / spring, hardening / spring)
    left -= ringing(link, spring, damper, step, finer, hardening, begin)
    quick = np.sqrt(spring / link.inertia[0])
    along = np.broadcast_to(np.linspace(-1.0, 1.0, link.load.size)[:, None], left.shape)
    columns = [
        ringing(link.unloaded(), spring, damper, step, finer, 0.0, np.array([unit, pace * quick]))
        for unit, pace in ((np.ones_like(spring), 0.0), (np.zeros_like(spring), 1.0))
    ]
    swings = np.stack([*columns, np.ones_like(left), along], axis=2)[known]
    own = np.einsum("nki,nkj->kij", swings, swings)
    own += LEAST_SWING * np.eye(4) * np.trace(own, axis1=1, axis2=2)[:, None, None]
    fitted = np.linalg.solve(own, np.einsum("nki,nk->ki", swings, left[known])[:, :, None])[:, :, 0]
    return np.asarray(begin + np.array([fitted[:, 0], fitted[:, 1] * quick]))


def flying(
    motion: Motion,
    link: Lagging,
    half: float | Floats,
    spring: float | Floats,
    damper: float | Floats,
    hardening: float = 0.0,
) -> Floats:
    """Return how far a link is behind the motor that flies within its play and swings on flanks that give.

    As :func:`swinging`, but the spring acts beyond ±``half`` the play only.
    """
    halves, springs, dampers, hard = np.broadcast_arrays(np.atleast_1d(half), spring, damper, hardening)
    finer, step = _steps(motion, FLIGHT_RATE)
    parts = [between_flanks(link.over(own), halves, springs, dampers, step, finer, hard) for own in motion.pieces]
    return np.concatenate(parts)


def coasting(motion: Motion, link: Lagging, backlash: float) -> Floats:
    """Return where the link is in its play, from −1 (ahead of the motor) to 1 (behind it), (n,).

    The link leaves its stop where the load changes sign.  Until it reaches a stop, it moves freely.  It does not bounce
    off a stop.  A link that stands above its axis leaves its stop only after the motor has moved it past its upright by
    half of the play.
    """
    out = np.empty_like(link.load)
    pull, back, drag = (
        course / link.inertia for course in (link.load / (0.5 * backlash), link.stiffness, link.damping)
    )
    finer, step = _steps(motion, FLIGHT_RATE)
    for own in motion.pieces:
        caught = round(1.0 / (step * motion.cutoff))
        out[own] = between_stops(pull[own], back[own], step, caught, finer, drag[own])
    return out


def _steps(motion: Motion, rate: float) -> tuple[int, float]:
    # How many steps to take per sample to integrate at a rate or more, and how long they are, s.
    finer = int(np.ceil(rate / motion.rate))
    return finer, 1.0 / (finer * motion.rate)
