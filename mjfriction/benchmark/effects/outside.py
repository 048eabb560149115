"""Effects that match no cause of the table: a diagnosis should say that structure is left, not name the nearest cause.

Each pushes its joint along the log's motion with a time course of its own; other motions are not pushed.
"""

from __future__ import annotations

import numpy as np
from scipy.signal import butter, lfilter, sosfiltfilt

from mjfriction.benchmark.effects.effect import OUTSIDE_NAME, Effect, Place
from mjfriction.laws.law import Floats

MOST = 5.0  # largest push, in units of the Coulomb level


def wander(rng: np.random.Generator, place: Place) -> Effect:
    """A torque that varies slowly: a hand on the arm, an amplifier that drifts back and forth."""
    return _outside("wander", place, _slow_noise(rng, place.time, rng.uniform(0.1, 0.6)))


def hum(rng: np.random.Generator, place: Place) -> Effect:
    """A torque periodic in time: another machine on the same floor."""
    phase = 2.0 * np.pi * (rng.uniform(0.8, 5.0) * place.time + rng.random())
    return _outside("hum", place, np.sin(phase))


def dragging_brake(rng: np.random.Generator, place: Place) -> Effect:
    """Friction whose level varies for no reason in the log."""
    level = _slow_noise(rng, place.time, rng.uniform(0.1, 0.4))
    speed = np.gradient(place.course, place.time)
    return _outside("dragging_brake", place, -np.tanh(speed / (0.02 * place.speed)) * np.maximum(0.0, 0.5 + level))


def soft_stop(rng: np.random.Generator, place: Place) -> Effect:
    """A stop that yields, at one end of the stroke: no torque at all before it."""
    way = float(rng.choice([-1.0, 1.0]))
    edge = np.quantile(way * place.course, rng.uniform(0.7, 0.9))
    return _outside("soft_stop", place, -way * np.maximum(0.0, way * place.course - edge) / place.stroke)


def sloshing(rng: np.random.Generator, place: Place) -> Effect:
    """A swinging load, driven by the joint's acceleration and lightly damped."""
    step = float(np.median(np.diff(place.time)))
    turn, fade = 2.0 * np.pi * rng.uniform(0.5, 1.5) * step, np.exp(-0.15 * step)
    acceleration = np.gradient(np.gradient(place.course, place.time), place.time)
    swing = lfilter([0.0, 1.0], [1.0, -2.0 * fade * np.cos(turn), fade**2], acceleration)
    return _outside("sloshing", place, swing)


OUTSIDE = (wander, hum, dragging_brake, soft_stop, sloshing)


def _slow_noise(rng: np.random.Generator, time: Floats, cutoff: float) -> Floats:
    # Noise below a cutoff (Hz), of RMS 1.
    rate = 1.0 / float(np.median(np.diff(time)))
    slow = sosfiltfilt(butter(2, cutoff, fs=rate, output="sos"), rng.standard_normal(time.size))
    return np.asarray(slow / np.std(slow))


def _outside(name: str, place: Place, course: Floats) -> Effect:
    push = place.coulomb * course / np.max(np.abs(course))
    return Effect(f"{OUTSIDE_NAME}{name}", place.joint, lambda robot, _: robot, 0.5, MOST, {}, push)
