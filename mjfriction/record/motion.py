"""The motion in a log: position, velocity and acceleration without phase lag, and the torques that drives reported."""

from __future__ import annotations

import functools
import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter1d

from mjfriction.errors import LogError
from mjfriction.record.fault import moment
from mjfriction.record.log import CURRENT, EFFORT, POSITION, VELOCITY, Floats, Integers, Log
from mjfriction.record.low_pass import ORDER, LowPass, butterworth, low_passed
from mjfriction.record.noise import raw_noise
from mjfriction.record.recorded_velocity import velocity_lateness
from mjfriction.record.resample import SHORTEST_PIECE, Clock, Grid, grid_segments, long_grids, onto_grid, read_clock

EDGE_PERIODS = 3  # periods of the cutoff by which a piece is extrapolated at both ends before it is filtered
SETTLING_PERIODS = 3.0  # periods of the cutoff at each end of a piece that the filter's start and end affect
MOST_OF_RATE = 0.45  # of the sampling rate, that the cutoff is at most
STILL = 1e-5  # rad or m; a joint that travels less counts as at rest
# A joint is held by its drive, and only yields a little, where its travel and its speed are both below this share of
# the largest among joints of its kind (sliding or turning).  As it may be the only one of its kind, it is also held
# below a smaller share of the largest of all joints, 1 m counting as 1 rad.
HELD, HELD_BESIDE_ANOTHER_KIND = 0.01, 0.001
# The same among joints of one kind; below both, friction stays near rest, where all laws agree.
DAWDLING = 0.04
USUALLY = 0.98  # quantile that stands for a joint's speed, as a joint may drop briefly when its controller takes over
SURE = 3.0  # standard deviations of the velocity's noise beyond which the direction of motion is known
TOP = 0.99  # quantile of speed that stands for a joint's top speed
LEAST_SPEED = 1e-12  # rad/s or m/s, in place of the velocity's noise for logs without any
# A joint that stops from any steady deceleration seems to swing back by 1.8 % of its fastest speed within two periods
# of the cutoff, as the fourth-order zero-phase filter rings by that much.
RINGING, RINGING_PERIODS = 0.02, 2.0
UNFOLDED = 0.35  # of the thinned rate; drive torques are low-passed there before thinning, to avoid aliasing


@dataclass(frozen=True)
class Motion:
    """The motion of the joints on an evenly spaced clock.

    ``position``, ``velocity``, ``acceleration`` have shape (n, joints): rad, rad/s, rad/s² (m on sliding joints).
    ``torque`` is what the drives reported, unfiltered, NaN where a joint has none; ``quantity`` says whether that is
    ``"effort"`` (N·m, N) or ``"current"`` (A).  ``velocity_noise`` (joints,) is the standard deviation of the
    estimated velocity's noise.  ``settled`` (n,) is False near the ends of pieces.  ``columns`` are the log's other
    columns on the same clock.  ``sliding`` (joints,) says which joints slide.  ``jump_free`` are the indices of the
    joints whose sensors' jumps across play (backlash) have been removed.
    """

    joints: tuple[str, ...]
    time: Floats
    piece: Integers
    rate: float
    cutoff: float
    position: Floats
    velocity: Floats
    acceleration: Floats
    velocity_noise: Floats
    torque: Floats
    quantity: tuple[str | None, ...]
    settled: NDArray[np.bool_]
    columns: dict[str, Floats]
    clock: Clock
    grids: tuple[Grid, ...]
    sliding: tuple[bool, ...]
    jump_free: frozenset[int] = frozenset()

    @functools.cached_property
    def pieces(self) -> tuple[slice, ...]:
        """The contiguous samples of each piece."""
        bounds = [0, *(np.flatnonzero(np.diff(self.piece)) + 1).tolist(), self.piece.size]
        return tuple(slice(first, past) for first, past in itertools.pairwise(bounds))

    @property
    def travel_noise(self) -> Floats:
        """Apparent travel of a joint from the velocity's noise, which is white in the filter's band, (joints,)."""
        return np.asarray(self.velocity_noise * np.sqrt(3.0) / (2.0 * np.pi * self.cutoff))

    @functools.cached_property
    def top_speed(self) -> Floats:
        """The speed that each joint exceeds in one sample of a hundred, (joints,)."""
        return np.asarray(np.quantile(np.abs(self.velocity), TOP, axis=0))

    @property
    def resting_speed(self) -> Floats:
        """Speed up to which noise alone can make a joint at rest seem to move, (joints,); always above 0."""
        return np.asarray(SURE * np.maximum(self.velocity_noise, LEAST_SPEED))

    @functools.cached_property
    def sure_speed(self) -> Floats:
        """Speed beyond which a joint's direction of motion is known, (n, joints): the larger of three standard
        deviations of the velocity's noise, and the ringing of the position filter after a stop.
        """
        reach = 2 * int(np.ceil(RINGING_PERIODS * self.rate / self.cutoff)) + 1
        fastest = np.concatenate([maximum_filter1d(np.abs(self.velocity[own]), reach, axis=0) for own in self.pieces])
        return np.maximum(self.resting_speed, RINGING * fastest)

    @functools.cached_property
    def moving(self) -> NDArray[np.bool_]:
        """Whether each joint moves anywhere in the log, shape (joints,).

        A joint that its drive holds while others move, and that only yields a little, does not.
        """
        least = np.maximum(20.0 * self.velocity_noise / max(self.cutoff, 1.0), STILL)
        travel, speed = self._usual_reach
        slack = HELD_BESIDE_ANOTHER_KIND
        lone = (travel < slack * np.max(travel)) & (speed < slack * np.max(speed))
        return np.asarray((travel > least) & ~self._below(HELD) & ~lone)

    @property
    def dawdling(self) -> NDArray[np.bool_]:
        """Whether each joint hardly moves compared to others of its kind, sliding or turning, shape (joints,).

        Such a joint is always as slow as others are during reversals, and stays within the travel in which contacts
        yield elastically.  Its friction there says nothing about its law.
        """
        return self._below(DAWDLING)

    def _below(self, share: float) -> NDArray[np.bool_]:
        # Whether both travel and speed are below a share of the largest among joints of a joint's kind, (joints,).
        travel, speed = self._usual_reach
        out = np.zeros(travel.size, dtype=bool)
        slides = np.array(self.sliding, dtype=bool)
        for kind in (slides, ~slides):
            most = [np.max(own[kind], initial=0.0) for own in (travel, speed)]
            out |= kind & (travel < share * most[0]) & (speed < share * most[1])
        return out

    @functools.cached_property
    def _usual_reach(self) -> tuple[Floats, Floats]:
        # The travel and the usual speed of each joint.
        return np.ptp(self.position, axis=0), np.quantile(np.abs(self.velocity), USUALLY, axis=0)

    def part(self, samples: slice | Integers) -> Motion:
        """Return the motion of some samples; its clock and grids remain those of the whole."""
        sampled = ("time", "piece", "position", "velocity", "acceleration", "torque", "settled")
        columns = {name: values[samples] for name, values in self.columns.items()}
        return replace(self, columns=columns, **{name: getattr(self, name)[samples] for name in sampled})

    def thinned(self, every: int) -> Motion:
        """Return the motion by one sample in ``every``.

        Positions are low-passed already and lose nothing, as long as a few samples remain per period of the cutoff.
        The reported torques are low-passed first, so that nothing aliases into their band.
        """
        if every == 1:
            return self
        thin = slice(None, None, every)
        torque = self.low_passed(self.torque, UNFOLDED * self.rate / every)
        part = replace(self, torque=torque).part(thin)
        grids = [replace(grid, time=part.time[part.piece == i]) for i, grid in enumerate(self.grids)]
        return replace(part, rate=self.rate / every, grids=tuple(grids))

    def stretches(self, samples: Integers) -> Motion:
        """Return the motion of some samples in ascending order, every run of neighbours within a piece as a piece."""
        part, of = self.part(samples), self.piece[samples]
        apart = (np.diff(samples) > 1) | (np.diff(of) != 0)
        first = np.append(0, np.flatnonzero(apart) + 1)
        parents = [self.grids[i] for i in of[first]]
        times = np.split(part.time, first[1:])
        grids = tuple(replace(parent, time=time) for parent, time in zip(parents, times, strict=True))
        return replace(part, piece=np.append(0, np.cumsum(apart)), grids=grids)

    def differentiated(self, values: Floats) -> Floats:
        """Return the time derivative of values (n, …) along the motion, each piece by central differences."""
        out = np.empty_like(values)
        for own in self.pieces:
            course, change = values[own], out[own]
            np.subtract(course[2:], course[:-2], out=change[1:-1])
            change[1:-1] *= 0.5
            change[0], change[-1] = course[1] - course[0], course[-1] - course[-2]
            change *= self.rate
        return out

    def low_passed(self, values: Floats, band: float) -> Floats:
        """Return values (n, …) along the motion, each piece through a zero-phase low-pass at ``band`` (Hz)."""
        out = np.empty_like(values)
        for own in self.pieces:
            out[own] = low_passed(values[own], self.rate, band)
        return out


def estimate_motion(log: Log, joints: Sequence[str], cutoff: float, sliding: Sequence[bool] | None = None) -> Motion:
    """Estimate velocity and acceleration of every joint by a zero-phase filter.

    Position is filtered forward and backward by a Butterworth low-pass of fourth order at ``cutoff`` (Hz) and
    differentiated by central differences of fourth order, piece by piece, so that nothing leaks across a gap or from
    one segment into the next.  Where the log has a measured velocity that is less noisy than the derivative of position
    and agrees with it, velocity and acceleration come from that instead, with its lag behind position removed.
    ``sliding`` (joints,) says which joints slide; without it all count as turning.

    Raises :class:`LogError` when no piece of the log is long enough, or where time does not increase from one segment
    to the next.
    """
    back = np.flatnonzero(np.diff(log.time) <= 0.0)
    if back.size:
        raise LogError(
            f"{log.source}: row {back[0] + 2}: time {moment(log.time[back[0] + 1])} s is not later than the "
            "row before; let the clock run on from segment to segment"
        )
    clock = read_clock(log)
    grids = long_grids(log, clock)
    if not grids:
        raise LogError(
            f"{log.source}: no stretch of {SHORTEST_PIECE} samples without a gap; "
            "record longer motions or a steadier log"
        )
    pieces = _Pieces(log, clock, grids, min(cutoff, MOST_OF_RATE / clock.step))
    courses = [pieces.course(joint) for joint in joints]
    used = {f"{q}.{joint}" for q in (POSITION, VELOCITY, EFFORT, CURRENT) for joint in joints}
    return Motion(
        joints=tuple(joints),
        time=np.concatenate([grid.time for grid in grids]),
        piece=grid_segments(grids),
        rate=pieces.rate,
        cutoff=pieces.cutoff,
        position=np.column_stack([course.position for course in courses]),
        velocity=np.column_stack([course.velocity for course in courses]),
        acceleration=np.column_stack([course.acceleration for course in courses]),
        velocity_noise=np.array([course.velocity_noise for course in courses]),
        torque=np.column_stack([course.torque for course in courses]),
        quantity=tuple(course.quantity for course in courses),
        settled=np.concatenate([_settled(grid.time.size, pieces.rate, pieces.cutoff) for grid in grids]),
        columns={
            name: np.concatenate(pieces.on_clock(values, smooth=False))
            for name, values in log.columns.items()
            if name not in used
        },
        clock=clock,
        grids=tuple(grids),
        sliding=tuple(sliding) if sliding is not None else (False,) * len(joints),
    )


@dataclass(frozen=True)
class _Course:
    """What one joint did, each (n,) but ``velocity_noise`` and ``quantity``, as in :class:`Motion`."""

    position: Floats
    velocity: Floats
    acceleration: Floats
    velocity_noise: float
    torque: Floats
    quantity: str | None


@dataclass(frozen=True)
class _Pieces:
    """The pieces of a log without gaps, on an even clock, and the cutoff (Hz) of the filter for positions."""

    log: Log
    clock: Clock
    grids: Sequence[Grid]
    cutoff: float

    @property
    def rate(self) -> float:
        return 1.0 / self.clock.step

    def on_clock(self, values: Floats, *, smooth: bool, late: float = 0.0) -> list[Floats]:
        return [onto_grid(values, self.log.time, grid, smooth=smooth, late=late) for grid in self.grids]

    def derivatives(self, pieces: list[Floats], order: int) -> list[Floats]:
        # Values through the low-pass, followed by as many of their derivatives as asked for, each (n,).
        edge = int(EDGE_PERIODS * self.rate / self.cutoff) + 12
        slow = butterworth(ORDER, self.cutoff, self.rate)
        smooth = [_low_pass(slow, piece, edge) for piece in pieces]
        out = [_derivatives(values, self.rate, order, margin) for values, margin in smooth]
        return [np.concatenate(parts) for parts in zip(*out, strict=True)]

    def course(self, joint: str) -> _Course:
        measured = self.log.channel(POSITION, joint)
        assert measured is not None, "check_joints lets no joint without a position pass"
        position, *rates = self.derivatives(self.on_clock(measured, smooth=True), 2)
        # A differentiator in front of a low-pass of this cutoff passes (2π·cutoff)²/3 of the noise's power in band.
        passed = np.sqrt(2.0 * self.cutoff / self.rate)
        noise = raw_noise(self.log, POSITION, joint, self.clock) * 2.0 * np.pi * self.cutoff * passed / np.sqrt(3.0)
        direct = self.log.channel(VELOCITY, joint)
        if direct is not None:
            direct_noise = raw_noise(self.log, VELOCITY, joint, self.clock) * passed
            late = velocity_lateness(self.log, joint, self.cutoff, self.clock) if direct_noise < noise else None
            if late is not None:
                rates, noise = self.derivatives(self.on_clock(direct, smooth=True, late=late), 1), direct_noise
        quantity = self.log.torque_quantity(joint)
        reported = self.log.channel(quantity, joint) if quantity else None
        return _Course(
            position=position,
            velocity=rates[0],
            acceleration=rates[1],
            velocity_noise=float(noise),
            torque=np.full(position.size, np.nan)
            if reported is None
            else np.concatenate(self.on_clock(reported, smooth=False)),
            quantity=quantity,
        )


def smooth_derivatives(motion: Motion, values: Floats, share: float = 1.0) -> list[Floats]:
    """Return values (n,) on a motion's clock through its position filter, with their two derivatives, each (n,).

    Values that are compared to filtered positions must be filtered in the same way.  A ``share`` of the cutoff below 1
    removes noise of the values themselves.
    """
    cutoff = share * motion.cutoff
    slow = butterworth(ORDER, cutoff, motion.rate)
    edge = int(EDGE_PERIODS * motion.rate / cutoff) + 12
    out = [np.empty_like(values) for _ in range(3)]
    for own in motion.pieces:
        smooth, margin = _low_pass(slow, values[own], edge)
        for part, derivative in zip(out, _derivatives(smooth, motion.rate, 2, margin), strict=True):
            part[own] = derivative
    return out


def back_to_log(motion: Motion, log: Log, values: Floats) -> Floats:
    """Return values on the motion's clock at the log's own rows, NaN in pieces too short to differentiate."""
    out = np.full(log.time.size, np.nan)
    start = 0
    for grid in motion.grids:
        stop = start + grid.time.size
        piece = values[start:stop]
        own = log.time[grid.rows]
        out[grid.rows] = np.interp(own, grid.time, piece) if grid.moved or piece.size != own.size else piece
        start = stop
    return out


def _low_pass(slow: LowPass, piece: Floats, edge: int) -> tuple[Floats, int]:
    # A log often starts or ends in the middle of a motion.  The piece is extrapolated at both ends by a cubic fitted to
    # each end, so that velocity and acceleration continue.  It is returned with that margin, so that derivatives at the
    # first and last sample are central ones too.
    margin = min(edge, piece.size - 1)
    before = _continued(piece[: margin + 1][::-1])[::-1]
    after = _continued(piece[-margin - 1 :])
    return slow.to_and_fro(np.concatenate([before, piece, after])), margin


def _continued(end: Floats) -> Floats:
    known = end.size // 2
    fit, powers = _cubic_through(known, end.size)
    return np.asarray(powers @ (fit @ end[known:]))


@functools.lru_cache(maxsize=64)
def _cubic_through(known: int, count: int) -> tuple[Floats, Floats]:
    # Two matrices for ``count`` values: one fits a cubic to all but the first ``known`` of them, the other evaluates it
    # at the ``count`` − 1 samples that follow.
    before, beyond = np.arange(1 + known - count, 1) / count, np.arange(1, count) / count
    return np.asarray(np.linalg.pinv(np.vander(before, 4)), dtype=float), np.vander(beyond, 4)


def _derivatives(values: Floats, rate: float, order: int, margin: int) -> list[Floats]:
    out = [values]
    for _ in range(order):
        previous = out[-1]
        derivative = np.gradient(previous) * rate
        derivative[2:-2] = (8.0 * (previous[3:-1] - previous[1:-3]) - (previous[4:] - previous[:-4])) * (rate / 12.0)
        out.append(derivative)
    return [array[margin : array.size - margin] for array in out]


def _settled(count: int, rate: float, cutoff: float) -> NDArray[np.bool_]:
    edge = min(int(np.ceil(SETTLING_PERIODS * rate / cutoff)), count // 2)
    mask = np.ones(count, dtype=bool)
    mask[:edge] = False
    mask[count - edge :] = False
    return mask
