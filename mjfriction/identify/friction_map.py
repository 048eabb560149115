"""Friction against speed from passes forward and backward over the same stretch: half their difference.

At the same place gravity acts alike in both directions, so that τ_f = (τ₊ − τ₋)/2 holds friction alone, with no model
of the links (Indri, Lazzero, Antoniazza, Bottero, ETFA 2013, section III).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mjfriction.identify.phases import Phase
from mjfriction.record.log import Floats
from mjfriction.record.motion import Motion

SAME_SPEED = 0.04  # relative, that two passes of one speed may differ by
FEWEST_SPEEDS = 3
OVERLAP = 0.3  # of the shorter pass, that both must share
BINS = 40  # places along a pass at which its directions are compared
CUTOFF = 10.0  # Hz, of the fourth-order Butterworth without phase lag that the torques pass


@dataclass(frozen=True)
class FrictionMap:
    """A joint's friction at each speed.

    ``speed`` (k,) > 0, ``friction`` (k,), its ``spread`` along the stroke (k,) and the ``gravity`` (k,) that cancelled,
    all in rad/s (m/s) and N·m (N) at the joint; ``places`` (k,) along the stroke that tell by themselves.
    """

    joint: int
    speed: Floats
    friction: Floats
    spread: Floats
    gravity: Floats
    places: Floats

    @property
    def error(self) -> Floats:
        """The standard error of each point: its spread over the root of its independent places, (k,)."""
        return np.asarray(np.maximum(self.spread, 1e-3 * np.max(self.friction)) / np.sqrt(self.places))


def friction_maps(motion: Motion, torque: Floats, phases: list[Phase]) -> list[FrictionMap]:
    """Return the maps of all joints that passed at three speeds or more in both directions.

    ``torque`` (n, joints) is the effort along the motion, N·m or N at the joint.
    """
    out = []
    for joint in range(torque.shape[1]):
        own = [phase for phase in phases if phase.joint == joint]
        if not own or not np.isfinite(torque[0, joint]):
            continue
        smooth = motion.low_passed(torque[:, joint], CUTOFF)
        points = [point for group in _by_speed(own) if (point := _point(motion, smooth, group)) is not None]
        if len(points) >= FEWEST_SPEEDS:
            columns = np.array(points).T
            out.append(FrictionMap(joint, *columns))
    return out


def _by_speed(phases: list[Phase]) -> list[list[Phase]]:
    groups: list[list[Phase]] = []
    for phase in sorted(phases, key=lambda phase: abs(phase.velocity)):
        if groups and abs(phase.velocity) < (1.0 + SAME_SPEED) * abs(groups[-1][0].velocity):
            groups[-1].append(phase)
        else:
            groups.append([phase])
    return groups


def _point(motion: Motion, torque: Floats, group: list[Phase]) -> tuple[float, ...] | None:
    forward = [phase for phase in group if phase.velocity > 0.0]
    backward = [phase for phase in group if phase.velocity < 0.0]
    frictions, gravities, speeds, places = [], [], [], 0.0
    for there, back in zip(forward, backward, strict=False):
        (q1, t1), (q2, t2) = (_course(motion, torque, phase) for phase in (there, back))
        low, high = max(q1[0], q2[0]), min(q1[-1], q2[-1])
        if high - low < OVERLAP * min(q1[-1] - q1[0], q2[-1] - q2[0]):
            continue
        place = np.linspace(low, high, BINS)
        a, b = np.interp(place, q1, t1), np.interp(place, q2, t2)
        frictions.append(0.5 * (a - b))
        gravities.append(0.5 * (a + b))
        speeds.append(0.5 * (there.velocity - back.velocity))
        # The low-pass lets two independent values a second through per hertz.
        places += min(float(BINS), max(1.0, 2.0 * CUTOFF * (high - low) / speeds[-1]))
    if not frictions:
        return None
    all_points = np.concatenate(frictions)
    spread = float(np.std(all_points, ddof=1))
    gravity = float(np.mean(np.concatenate(gravities)))
    return float(np.mean(speeds)), float(np.mean(all_points)), spread, gravity, places


def _course(motion: Motion, torque: Floats, phase: Phase) -> tuple[Floats, Floats]:
    samples = slice(phase.first, phase.past)
    position, own = motion.position[samples, phase.joint], torque[samples]
    order = np.argsort(position, kind="stable")
    return position[order], own[order]
