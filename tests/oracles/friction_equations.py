"""The friction laws once more, as differential equations straight from the papers, for scipy's Radau and for Euler.

Nothing here is shared with the package: numbers come in as plain arguments, not packed values.
"""

from __future__ import annotations

import numpy as np
from scipy.integrate import solve_ivp


def gaussian(v, fc, fs, vs, delta):
    return fc + (fs - fc) * np.exp(-(np.abs(v) ** delta) / vs**delta)


def dahl_rate(v, f, fc, s0, delta):
    r = 1.0 - f / fc * np.sign(v)
    return s0 * np.abs(r) ** delta * np.sign(r) * v


def lugre_rate(v, z, level, s0):
    return v - s0 * abs(v) / level * z


def smooth_rate(v, z, level, s0, kv):
    s = 2.0 / np.pi * np.arctan(kv * v)
    return s * s * v - s0 * s * v / level * z


def elasto_plastic_rate(v, z, level, s0, zba):
    zmax = level / s0
    if np.sign(v) != np.sign(z) or abs(z) <= zba:
        alpha = 0.0
    elif abs(z) >= zmax:
        alpha = 1.0
    else:
        alpha = 0.5 * np.sin(np.pi * (abs(z) - 0.5 * (zmax + zba)) / (zmax - zba)) + 0.5
    return v * (1.0 - alpha * z * np.sign(v) / zmax)


def integrate(rate, velocity, times, **options):
    """State of dz/dt = rate(v(t), z) from rest at the given times."""
    out = solve_ivp(
        lambda t, z: [rate(velocity(t), z[0])],
        (0.0, times[-1]),
        [0.0],
        "Radau",
        times,
        rtol=1e-10,
        atol=1e-14,
        **options,
    )
    return out.y[0]


def gms_by_euler(v, h, level, k, alpha, attraction):
    """Element forces of the Generalized Maxwell-Slip law along ``v``, by explicit Euler and its switching rules."""
    force, slipping = np.zeros(len(k)), np.zeros(len(k), bool)
    total = np.empty(len(v))
    before = 0.0
    for n, velocity in enumerate(v):
        if velocity * before <= 0.0:
            slipping[:] = False
        s = np.sign(velocity) * level(velocity)
        slipping |= (np.abs(force) > alpha * abs(s)) & (force * velocity > 0.0)
        rate = np.where(
            slipping, np.sign(velocity) * attraction * (alpha - force / s) if velocity else 0.0, k * velocity
        )
        force = force + h * rate
        total[n] = force.sum()
        before = velocity
    return total


def leuven_by_euler(v, h, level, k, w, sigma1, delta):
    """Torque of the Leuven law without its viscous part along ``v``, by explicit Euler on z and the sliders."""
    z, slider = 0.0, np.zeros(len(k))
    total = np.empty(len(v))
    for n, velocity in enumerate(v):
        fh = float(np.sum(k * (z - slider)))
        r = fh / (np.sign(velocity) * level(velocity)) if velocity else 0.0
        rate = velocity * (1.0 - np.sign(r) * abs(r) ** delta)
        z += h * rate
        stretch = z - slider
        over = np.abs(stretch) > w / k
        slider = np.where(over, z - np.sign(stretch) * w / k, slider)
        total[n] = float(np.sum(k * (z - slider))) + sigma1 * rate
    return total
