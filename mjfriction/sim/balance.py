"""The implicit step of all joints with friction together.

S·(v⁺ − v) + h·φ(v⁺, z) = b, with S the inertia of the rubbing joints (all others free to move), b the step's impulse of
every other force, and φ the friction at the end of the step.  φ does not fall with v⁺ but on a Stribeck branch, so that
Newton's method finds the one solution in two or three rounds; where it does not, each joint is bracketed in turn.
"""

from __future__ import annotations

from mjfriction.laws.law import Floats, kernel
from mjfriction.sim.rub import rub, rub_one
from mjfriction.sim.solve import solve_spd

ROUNDS = 25
SWEEPS = 60
BISECTIONS = 200
TOLERANCE = 1e-11  # of a velocity
FLOOR = 1e-14  # rad/s or m/s


@kernel
def balance(
    s: Floats, b: Floats, start: Floats, block: Floats, terms: Floats, jumps: Floats, around: Floats, z: Floats,
    h: float, v: Floats, change: Floats, work: Floats, torque: Floats, slope: Floats, z_next: Floats, near: Floats,
) -> int:  # fmt: skip
    """Write the velocities at the end of the step into ``v`` (k,) and return the rounds it took, −1 where none did.

    ``s`` (k, k; lower triangle), ``b`` and ``start`` = v (k,); ``jumps`` (k,) marks joints whose torque jumps at rest.
    ``v`` comes in as a first guess.  ``change``, ``torque``, ``slope`` (k,) and ``work`` (k, k) are room to work in.
    """
    k = v.shape[0]
    for round_ in range(ROUNDS):
        rub(block, terms, v, around, z, h, z_next, near, torque, slope)
        for i in range(k):
            residual = b[i] - h * torque[i]
            for j in range(k):
                entry = s[i, j] if j <= i else s[j, i]
                residual -= entry * (v[j] - start[j])
                work[i, j] = entry
            work[i, i] += h * slope[i]
            change[i] = residual
        solve_spd(work, change)
        settled = True
        for i in range(k):
            moved = v[i] + change[i]
            if jumps[i] > 0.0 and v[i] * moved < 0.0:
                # Past rest the torque jumps: stop there first, where the joint may stick.
                moved = 0.0
            if abs(moved - v[i]) > TOLERANCE * abs(moved) + FLOOR:
                settled = False
            v[i] = moved
        if settled:
            return round_ + 1
    return bracketed(s, b, start, block, terms, around, z, h, v, z_next, near)


@kernel
def bracketed(
    s: Floats, b: Floats, start: Floats, block: Floats, terms: Floats, around: Floats, z: Floats, h: float, v: Floats,
    z_next: Floats, near: Floats,
) -> int:  # fmt: skip
    """Solve joint by joint, each within a bracket that friction's dissipation guarantees, until none moves."""
    k = v.shape[0]
    for sweep in range(SWEEPS):
        settled = True
        for i in range(k):
            pull = b[i] + s[i, i] * start[i]
            for j in range(k):
                if j != i:
                    pull -= (s[i, j] if j < i else s[j, i]) * (v[j] - start[j])
            low, high = min(0.0, pull / s[i, i]), max(0.0, pull / s[i, i])
            reach = high - low + 1e-9
            while s[i, i] * low + h * rub_one(block, terms, i, low, around, z, h, z_next, near) > pull:
                low -= reach
                reach *= 2.0
            while s[i, i] * high + h * rub_one(block, terms, i, high, around, z, h, z_next, near) < pull:
                high += reach
                reach *= 2.0
            for _ in range(BISECTIONS):
                middle = 0.5 * (low + high)
                if middle in (low, high):
                    break
                if s[i, i] * middle + h * rub_one(block, terms, i, middle, around, z, h, z_next, near) > pull:
                    high = middle
                else:
                    low = middle
            middle = 0.5 * (low + high)
            if abs(middle - v[i]) > 1e-9 * abs(middle) + 1e-12:
                settled = False
            v[i] = middle
        if settled:
            return ROUNDS + sweep + 1
    return -1
