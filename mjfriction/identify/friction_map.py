"""Friction against speed from passes forward and backward over the same stretch: half their difference.

At the same place gravity acts alike in both directions.  So τ_f = (τ₊ − τ₋)/2 contains friction alone, without a model
of the links, and τ_m = (τ₊ + τ₋)/2 is the load that the joint transmits (Indri, Lazzero, Antoniazza, Bottero, ETFA
2013, section III).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mjfriction.identify.phases import Phase
from mjfriction.record.log import Floats
from mjfriction.record.motion import Motion

SAME_SPEED = 0.04  # relative difference within which passes have the same speed
FEWEST_SPEEDS = 3
OVERLAP = 0.3  # share of the shorter pass that both must cover
BINS = 40  # places along a pass at which its directions are compared
# Difference within which passes have the same load, as a share of the most that a joint carries or rubs with.
SAME_LOAD = 0.1
CUTOFF = 10.0  # Hz, of the zero-phase fourth-order Butterworth low-pass for the torques


@dataclass(frozen=True)
class FrictionMap:
    """A joint's friction at each speed.

    ``speed`` (k,) > 0 in rad/s (m/s); ``friction`` (k,), its ``spread`` along the stroke (k,) and the ``load`` (k,),
    the mean size of the gravity that cancelled, in N·m (N), all at the joint.  ``places`` (k,) is how many places along
    the stroke are independent.  A speed that was passed at different loads has a point for each.
    """

    joint: int
    speed: Floats
    friction: Floats
    spread: Floats
    load: Floats
    places: Floats

    @property
    def error(self) -> Floats:
        """The standard error of each point: its spread over the root of its independent places, (k,)."""
        return np.asarray(np.maximum(self.spread, 1e-3 * np.max(self.friction)) / np.sqrt(self.places))

    def up_to(self, speed: float) -> FrictionMap:
        """Return the map with the points up to a speed, rad/s or m/s."""
        own = self.speed <= speed
        points = (self.speed, self.friction, self.spread, self.load, self.places)
        return FrictionMap(self.joint, *(values[own] for values in points))

    @property
    def tells_load(self) -> bool:
        """Whether three speeds or more were passed at different loads."""
        same = self.speed[1:] < (1.0 + SAME_SPEED) * self.speed[:-1]
        return int(np.count_nonzero(same)) >= FEWEST_SPEEDS


def friction_maps(motion: Motion, torque: Floats, phases: list[Phase]) -> list[FrictionMap]:
    """Return the maps of all joints that made passes at three speeds or more in both directions.

    ``torque`` (n, joints) is the effort along the motion, N·m or N at the joint.
    """
    out = []
    for joint in range(torque.shape[1]):
        own = [phase for phase in phases if phase.joint == joint]
        if not own or not np.isfinite(torque[0, joint]):
            continue
        smooth = motion.low_passed(torque[:, joint], CUTOFF)
        speeds = [_pairs(motion, smooth, group) for group in _by_speed(own)]
        points = [_point(group) for pairs in speeds for group in _by_load(pairs, _size(speeds))]
        if sum(bool(pairs) for pairs in speeds) >= FEWEST_SPEEDS:
            out.append(FrictionMap(joint, *np.array(points).T))
    return out


@dataclass(frozen=True)
class _Pair:
    """A pass forward and one back: friction and load at places (BINS,) that both covered."""

    speed: float
    friction: Floats
    load: Floats
    places: float

    @property
    def carried(self) -> float:
        return float(np.mean(np.abs(self.load)))


def _by_speed(phases: list[Phase]) -> list[list[Phase]]:
    groups: list[list[Phase]] = []
    for phase in sorted(phases, key=lambda phase: abs(phase.velocity)):
        if groups and abs(phase.velocity) < (1.0 + SAME_SPEED) * abs(groups[-1][0].velocity):
            groups[-1].append(phase)
        else:
            groups.append([phase])
    return groups


def _pairs(motion: Motion, torque: Floats, group: list[Phase]) -> list[_Pair]:
    # Sort by time, so that passes of the same log are paired when there are two logs.
    inorder = sorted(group, key=lambda phase: phase.first)
    forward = [phase for phase in inorder if phase.velocity > 0.0]
    backward = [phase for phase in inorder if phase.velocity < 0.0]
    out = []
    for there, back in zip(forward, backward, strict=False):
        (q1, t1), (q2, t2) = (_course(motion, torque, phase) for phase in (there, back))
        low, high = max(q1[0], q2[0]), min(q1[-1], q2[-1])
        if high - low < OVERLAP * min(q1[-1] - q1[0], q2[-1] - q2[0]):
            continue
        place = np.linspace(low, high, BINS)
        a, b = np.interp(place, q1, t1), np.interp(place, q2, t2)
        speed = 0.5 * (there.velocity - back.velocity)
        # The low-pass passes two independent values per second per hertz.
        places = min(float(BINS), max(1.0, 2.0 * CUTOFF * (high - low) / speed))
        out.append(_Pair(speed, 0.5 * (a - b), 0.5 * (a + b), places))
    return out


def _size(speeds: list[list[_Pair]]) -> float:
    # The most that a joint carries or rubs with: the scale on which loads are compared.
    pairs = [pair for group in speeds for pair in group]
    return max((max(pair.carried, float(np.mean(pair.friction))) for pair in pairs), default=0.0)


def _by_load(pairs: list[_Pair], size: float) -> list[list[_Pair]]:
    groups: list[list[_Pair]] = []
    for pair in sorted(pairs, key=lambda pair: pair.carried):
        if groups and pair.carried < groups[-1][0].carried + SAME_LOAD * size:
            groups[-1].append(pair)
        else:
            groups.append([pair])
    return groups


def _point(pairs: list[_Pair]) -> tuple[float, ...]:
    friction = np.concatenate([pair.friction for pair in pairs])
    return (
        float(np.mean([pair.speed for pair in pairs])),
        float(np.mean(friction)),
        float(np.std(friction, ddof=1)),
        float(np.mean([pair.carried for pair in pairs])),
        float(sum(pair.places for pair in pairs)),
    )


def _course(motion: Motion, torque: Floats, phase: Phase) -> tuple[Floats, Floats]:
    samples = slice(phase.first, phase.past)
    position, own = motion.position[samples, phase.joint], torque[samples]
    order = np.argsort(position, kind="stable")
    return position[order], own[order]
