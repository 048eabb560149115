"""The implicit step of all joints with friction together.

S·(v⁺ − v) + h·φ(v⁺, z) = b, with S the inertia of the rubbing joints (all others free to move), b the step's impulse of
every other force, and φ the friction at the end of the step.  φ falls with v⁺ only on a Stribeck branch, so Newton's
method finds the one solution in two or three rounds.  Where it does not, each joint is bracketed in turn.
"""

from __future__ import annotations

from mjfriction.laws.law import Floats, kernel, routine
from mjfriction.laws.window import address
from mjfriction.sim.rub import rub
from mjfriction.sim.solve import solve_spd

ROUNDS = 25
SWEEPS = 60
BISECTIONS = 60
# A velocity correction below this relative size ends the iteration.  The relative error that it leaves in the torque is
# smaller still: the part that the slope leaves out (the falling branch, whose slope would be negative) is never steeper
# than torque over velocity.
TOLERANCE = 1e-5
FLOOR = 1e-13  # rad/s or m/s
BALANCED = 1e-7  # largest residual, as a fraction of the impulses in the balance
# The same for the first guess: what is off by no more than rounding.  The end of the step would not depend on what a
# guess that is taken is off by, and finite differences over small controls would be zero.
GUESSED = 1e-13


@kernel
def lacking(
    s: Floats, b: Floats, start: Floats, h: float, v: Floats, torque: Floats, residual: Floats, least: float
) -> bool:
    """Write the residual of the balance into ``residual`` (k,) and return whether it needs another round, being more
    than ``least`` of the impulses.
    """
    found = False
    for i in range(v.shape[0]):
        missing = b[i] - h * torque[i]
        size = abs(b[i]) + h * abs(torque[i])
        for j in range(v.shape[0]):
            missing -= s[i, j] * (v[j] - start[j])
        residual[i] = missing
        # Balanced: small relative to the forces and too small to move the joint.  Written so that a NaN is not.
        if not (abs(missing) <= least * size and abs(missing) <= s[i, i] * (least * abs(v[i]) + FLOOR)):
            found = True
    return found


@kernel
def bend(
    s: Floats, h: float, v: Floats, torque: Floats, v_before: Floats, torque_before: Floats, slope: Floats
) -> None:
    """Where the torque fell between the last two rounds, take its secant as the slope (k,); the laws give 0 there.

    The slope is limited to half of the one that would make the joint's own balance singular.
    """
    for i in range(v.shape[0]):
        apart = v[i] - v_before[i]
        if abs(apart) > 1e-9 * abs(v[i]) + FLOOR:
            seen = (torque[i] - torque_before[i]) / apart
            if seen < 0.0:
                slope[i] = max(seen, -0.5 * s[i, i] / h)


@kernel
def balance(
    s: Floats, b: Floats, start: Floats, block: int, terms: int, count: int, around: int, z: int,
    h: float, z_next: int, near: int, v: Floats, change: Floats, work: Floats, torque: Floats, slope: Floats,
    v_before: Floats, torque_before: Floats,
) -> int:  # fmt: skip
    """Write the velocities at the end of the step into ``v`` (k,) and return the rounds it took, −1 without a balance.

    On return ``torque`` and the states at ``z_next`` are those at ``v``; ``change`` is the impulse that the balance
    still lacks.

    ``s`` (k, k) is symmetric; ``b`` and ``start`` = v are (k,); ``block`` to ``near`` are the arguments of
    :mod:`mjfriction.sim.rub`, arrays as addresses.  ``v`` holds a first guess on entry.  The other arrays, (k,), and
    ``work`` (k, k) are work space.
    """
    k = v.shape[0]
    settled = False
    for round_ in range(ROUNDS):
        rub(block, terms, count, 0, k, address(v, 0), around, z, h, z_next, near, address(torque, 0), address(slope, 0))
        if not lacking(s, b, start, h, v, torque, change, GUESSED if round_ == 0 else BALANCED) or settled:
            return round_ + 1
        if round_ > 0:
            bend(s, h, v, torque, v_before, torque_before, slope)
        for i in range(k):
            v_before[i], torque_before[i] = v[i], torque[i]
            for j in range(i + 1):
                work[i, j] = s[i, j]
            work[i, i] += h * slope[i]
        solve_spd(work, change)
        settled = True
        for i in range(k):
            moved = v[i] + change[i]
            if v[i] * moved < 0.0:
                # Beyond rest the torque reverses.  Either the joint slides on against it, or it sticks.
                turned = moved + 2.0 * h * torque[i] / (s[i, i] + h * slope[i])
                moved = turned if turned * moved > 0.0 else 0.0
            if abs(moved - v[i]) > TOLERANCE * abs(moved) + FLOOR:
                settled = False
            v[i] = moved
    return bracketed(s, b, start, block, terms, count, around, z, h, z_next, near, v, change, torque, slope)


@routine
def excess(
    s: Floats, i: int, pull: float, at: float, block: int, terms: int, count: int, around: int, z: int, h: float,
    z_next: int, near: int, v: Floats, torque: Floats, slope: Floats,
) -> float:  # fmt: skip
    """Return how much more impulse than ``pull`` joint ``i`` needs to move at ``at``; ``v`` (k,) is work space."""
    v[i] = at
    at_torque, at_slope = address(torque, 0), address(slope, 0)
    rub(block, terms, count, i, i + 1, address(v, 0), around, z, h, z_next, near, at_torque, at_slope)
    return float(s[i, i] * at + h * torque[i] - pull)


@routine
def bracketed(
    s: Floats, b: Floats, start: Floats, block: int, terms: int, count: int, around: int, z: int, h: float, z_next: int,
    near: int, v: Floats, trial: Floats, torque: Floats, slope: Floats,
) -> int:  # fmt: skip
    """Solve joint by joint, each within a bracket that friction's dissipation guarantees, until none moves."""
    k = v.shape[0]
    at_torque, at_slope = address(torque, 0), address(slope, 0)
    for sweep in range(SWEEPS):
        settled = True
        for i in range(k):
            pull = b[i] + s[i, i] * start[i]
            for j in range(k):
                if j != i:
                    pull -= s[i, j] * (v[j] - start[j])
            low, high = min(0.0, pull / s[i, i]), max(0.0, pull / s[i, i])
            reach = high - low + 1e-9
            while excess(s, i, pull, low, block, terms, count, around, z, h, z_next, near, trial, torque, slope) > 0.0:
                low -= reach
                reach *= 2.0
            while excess(s, i, pull, high, block, terms, count, around, z, h, z_next, near, trial, torque, slope) < 0.0:
                high += reach
                reach *= 2.0
            for _ in range(BISECTIONS):
                middle = 0.5 * (low + high)
                if middle in (low, high):
                    break
                if (
                    excess(s, i, pull, middle, block, terms, count, around, z, h, z_next, near, trial, torque, slope)
                    > 0.0
                ):
                    high = middle
                else:
                    low = middle
            middle = 0.5 * (low + high)
            if abs(middle - v[i]) > 1e-9 * abs(middle) + 1e-12:
                settled = False
            v[i] = middle
        if settled or sweep == SWEEPS - 1:
            rub(block, terms, count, 0, k, address(v, 0), around, z, h, z_next, near, at_torque, at_slope)
            lacking(s, b, start, h, v, torque, trial, BALANCED)
            return ROUNDS + sweep + 1 if settled else -1
    return -1
