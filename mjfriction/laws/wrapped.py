"""Kernels that wrap any law: seen through a gear, with its level scaled by ambient quantities and two directions.

A wrapped law is one float64 vector ``w``, built by :meth:`mjfriction.laws.friction.Friction.packed`: number of the law,
gear ratio, count of parameters, index of its linear damping or −1, flag for two directions, flag for a load that
includes the rotor, flag for a scaled level, level per load, level per kelvin, reference temperature, count of waves,
then k, a, b of each wave, the parameters, and, with two directions, the parameters for backward motion.
"""

from __future__ import annotations

import math

from mjfriction.laws.ambient import LOAD, POSITION, PRESSURE_HEAD, PRESSURE_ROD, ROTOR, SLIDING, TEMPERATURE
from mjfriction.laws.dispatch import advance_of, steady_of
from mjfriction.laws.law import Floats, kernel, routine
from mjfriction.laws.window import address, window

NUMBER, RATIO, COUNT, DAMPING, TWO_WAY, WHOLE, LEVELLED, PER_LOAD, PER_KELVIN, REFERENCE, WAVES, HEADER = range(12)


@kernel
def through_gear(ambient: Floats, w: Floats, near: Floats) -> None:
    """Write the ambient quantities on the law's side of a gear into ``near``.

    Position and sliding velocity are multiplied by the ratio, load and rotor torque are divided by it.  The load
    includes the rotor torque where the law's load does.
    """
    ratio = w[RATIO]
    near[ROTOR] = ambient[ROTOR] / ratio
    near[LOAD] = ambient[LOAD] / ratio + w[WHOLE] * near[ROTOR]
    near[POSITION] = ambient[POSITION] * ratio
    near[TEMPERATURE] = ambient[TEMPERATURE]
    near[PRESSURE_HEAD] = ambient[PRESSURE_HEAD]
    near[PRESSURE_ROD] = ambient[PRESSURE_ROD]
    near[SLIDING] = ambient[SLIDING] * ratio


@kernel
def level_factor(near: Floats, w: Floats) -> float:
    """Return the factor on the level, max(0, 1 + μ·|τ| + α·(T − T₀) + Σ aᵢ·cos(kᵢq) + bᵢ·sin(kᵢq))."""
    factor = 1.0 + w[PER_LOAD] * abs(near[LOAD]) + w[PER_KELVIN] * (near[TEMPERATURE] - w[REFERENCE])
    for i in range(int(w[WAVES])):
        at = HEADER + 3 * i
        angle = w[at] * near[POSITION]
        factor += w[at + 1] * math.cos(angle) + w[at + 2] * math.sin(angle)
    return float(max(0.0, factor))


@kernel
def steady_wrapped(v: float, ambient: Floats, w: Floats, near: Floats) -> float:
    """Return the steady torque at the joint; ``near`` (7,) is a work array."""
    number, count, at = int(w[NUMBER]), int(w[COUNT]), HEADER + 3 * int(w[WAVES])
    through_gear(ambient, w, near)
    own = w[RATIO] * v
    if w[TWO_WAY] > 0.0 and own < 0.0:
        at += count
    p = window(w, at, count)
    factor = level_factor(near, w)
    damping = p[int(w[DAMPING])] if w[DAMPING] >= 0.0 else 0.0
    return float(w[RATIO] * (factor * steady_of(number, own, near, p) + (1.0 - factor) * damping * own))


@kernel
def advance_wrapped(
    v: float, ambient: Floats, z: Floats, h: float, w: Floats, z_next: Floats, near: Floats
) -> tuple[float, float]:
    """Return (torque, slope) at the joint and write the next state; ``near`` (7,) is a work array.

    The factor s on the level multiplies all but the linear damping: s·(τ − F_v·v) + F_v·v.  A law with two directions
    runs one copy for each direction, each with its own state, and its torque is max(τ⁺, 0) + min(τ⁻, 0).  That is
    continuous, and its slope is that of the copies that contribute, or the steeper one if neither does.
    """
    number, count, ratio = int(w[NUMBER]), int(w[COUNT]), w[RATIO]
    if ratio == 1.0 and w[LEVELLED] == 0.0 and w[TWO_WAY] == 0.0 and w[WHOLE] == 0.0:
        # Nothing to wrap: the common case, and the fast path.
        return advance_of(
            number, v, address(ambient, 0), address(z, 0), z.shape[0], h, address(w, HEADER), count, address(z_next, 0)
        )
    at = HEADER + 3 * int(w[WAVES])
    around = ambient
    if ratio != 1.0 or w[WHOLE] > 0.0:
        through_gear(ambient, w, near)
        around = near
    own = ratio * v
    factor = level_factor(around, w) if w[LEVELLED] > 0.0 else 1.0
    ways, half = 1, z.shape[0]
    if w[TWO_WAY] > 0.0:
        ways, half = 2, z.shape[0] // 2
    total = steepness = steepest = 0.0
    for way in range(ways):
        here = at + way * count
        torque, slope = advance_of(
            number,
            own,
            address(around, 0),
            address(z, way * half),
            half,
            h,
            address(w, here),
            count,
            address(z_next, way * half),
        )
        kept = (1.0 - factor) * w[here + int(w[DAMPING])] if w[DAMPING] >= 0.0 else 0.0
        torque = factor * torque + kept * own
        slope = max(0.0, factor * slope + kept)
        steepest = max(steepest, slope)
        if ways == 1 or (torque > 0.0 if way == 0 else torque < 0.0):
            total += torque
            steepness += slope
    return ratio * total, ratio * ratio * (steepness if total != 0.0 or ways == 1 else steepest)


@routine
def steady_wrapped_along(velocity: Floats, ambient: Floats, w: Floats, near: Floats, out: Floats) -> None:
    """Write the steady torque of every sample into ``out``."""
    for i in range(velocity.shape[0]):
        out[i] = steady_wrapped(velocity[i], ambient[i], w, near)


@routine
def advance_wrapped_along(
    velocity: Floats, ambient: Floats, h: float, w: Floats, start: Floats, near: Floats, torque: Floats, states: Floats
) -> None:
    """Write torque and state at the end of every step into ``torque`` (n,) and ``states`` (n, states)."""
    z = start
    for i in range(velocity.shape[0]):
        torque[i], _ = advance_wrapped(velocity[i], ambient[i], z, h, w, states[i], near)
        z = states[i]
