"""Jumps of a position sensor: found where they come with the load, by their size, and taken off the motion."""

from __future__ import annotations

import numpy as np
import pyarrow as pa
import pytest
from scipy.ndimage import gaussian_filter1d

from mjfriction.record import jumps as module
from mjfriction.record.jump_free import without_jumps
from mjfriction.record.jumps import Jumps, find_jumps
from mjfriction.record.log import Floats, Log
from mjfriction.record.motion import Motion, estimate_motion
from mjfriction.record.readers.table import log_from_table

RATE, SECONDS, PLAY = 250.0, 40.0, 2e-3
CUTOFF = 30.0


def course(time: Floats) -> tuple[Floats, Floats]:
    # A motion and its rate of change.
    amplitude, frequency, phase = np.array([[0.8, 0.5, 0.2], [0.9, 2.1, 3.7], [0.3, 1.0, 2.0]])
    angle = np.outer(time, frequency) + phase
    return np.sin(angle) @ amplitude, np.cos(angle) @ (amplitude * frequency)


def pull(time: Floats) -> Floats:
    return np.sin(1.7 * time) + 0.4 * np.sin(4.1 * time + 0.5)


def recorded(stands: Floats, seed: int = 0, noise: float = 2e-5, velocity: Floats | None = None) -> Log:
    time = np.arange(stands.size) / RATE
    q, _ = course(time)
    read = q + 0.5 * PLAY * stands + np.random.default_rng(seed).normal(0.0, noise, time.size)
    columns = {"time": time, "position.axis": read, "effort.axis": pull(time)}
    return log_from_table(pa.table(columns | ({} if velocity is None else {"velocity.axis": velocity})), "log")


def seen(log: Log, load: Floats | None = None) -> tuple[Motion, Jumps | None]:
    motion = estimate_motion(log, ("axis",), CUTOFF)
    known = pull(motion.time) if load is None else load
    return motion, find_jumps(log, motion, lambda along: known[:, None]).get(0)


@pytest.fixture
def time() -> Floats:
    return np.arange(int(SECONDS * RATE)) / RATE


@pytest.mark.parametrize(("edge", "noise"), [(0.0, 2e-5), (0.0, 1e-4), (6e-3, 2e-5), (6e-3, 1e-4), (12e-3, 2e-5)])
def test_jumps_are_found_with_their_size(edge: float, noise: float, time: Floats) -> None:
    stands = np.sign(pull(time))
    crossings = np.count_nonzero(np.diff(stands))
    log = recorded(gaussian_filter1d(stands, edge * RATE) if edge else stands, noise=noise)
    _, jumps = seen(log)
    assert jumps is not None
    assert (jumps.count, jumps.turns) == (crossings, crossings)
    assert jumps.size - jumps.half_width < PLAY < jumps.size + jumps.half_width
    assert jumps.half_width < 0.1 * PLAY
    assert np.mean(jumps.course * stands > 0.9) > 0.95


@pytest.mark.parametrize("load_off", [0.9, 1.15])
def test_a_load_that_is_a_little_off_tells_the_same_jumps(load_off: float, time: Floats) -> None:
    _, jumps = seen(recorded(np.sign(pull(time))), pull(time) + (load_off - 1.0) * np.sin(1.7 * time))
    assert jumps is not None
    assert jumps.size == pytest.approx(PLAY, rel=0.02)


def test_jumps_that_do_not_come_with_the_load_are_no_play(time: Floats) -> None:
    rng = np.random.default_rng(3)
    at = np.sort(rng.uniform(1.0, SECONDS - 1.0, 30))
    stands = 1.0 - 2.0 * (np.searchsorted(at, time) % 2)
    assert seen(recorded(stands))[1] is None
    assert seen(recorded(-np.sign(pull(time))))[1] is None  # the sensor would run ahead of a link that pulls it back
    assert seen(recorded(np.zeros_like(time)))[1] is None


def test_steps_of_any_size_are_no_play(time: Floats) -> None:
    stands = np.sign(pull(time))
    turns = np.cumsum(np.abs(np.diff(stands, prepend=stands[0])) > 0.0)
    uneven = np.random.default_rng(1).lognormal(0.0, 1.0, turns[-1] + 1)[turns] * stands
    assert seen(recorded(uneven))[1] is None


@pytest.mark.parametrize("flight", [0.08, 0.12])
def test_a_link_that_flies_across_its_play_moves_its_sensor_in_no_step(
    flight: float, time: Floats, monkeypatch: pytest.MonkeyPatch
) -> None:
    side = np.sign(pull(time))
    turns = np.flatnonzero(np.diff(side, prepend=side[0]))
    left = time - time[turns[np.maximum(np.searchsorted(turns, np.arange(time.size), side="right") - 1, 0)]]
    stands = np.where((left < 0.0) | (left > flight), side, side * (2.0 * (left / flight) ** 2 - 1.0))
    log = recorded(stands, noise=2e-6)
    assert seen(log)[1] is None
    # Taken for a step, it is one of less than the play, and surely so: what no polynomial follows is the landing.
    monkeypatch.setattr(module, "NO_STEP", 1.0)
    _, mistaken = seen(log)
    assert mistaken is not None
    assert mistaken.size + mistaken.half_width < PLAY


def test_without_its_jumps_a_motion_is_the_links(time: Floats) -> None:
    log = recorded(np.sign(pull(time)))
    motion, jumps = seen(log)
    assert jumps is not None
    clean = estimate_motion(recorded(np.zeros_like(time)), ("axis",), CUTOFF)
    cleared = without_jumps(log, motion, {0: (jumps.size, jumps.course)})
    assert cleared.jump_free == {0}
    inner = slice(200, -200)
    for name, least in (("velocity", 0.02), ("acceleration", 0.02)):
        now, before, true = (getattr(one, name)[inner, 0] for one in (cleared, motion, clean))
        assert np.std(now - true) < least * np.std(before - true)


@pytest.mark.parametrize("along", [False, True])
def test_a_measured_velocity_that_jumps_along_is_left_out(along: bool, time: Floats) -> None:
    stands = np.sign(pull(time))
    _, v = course(time)
    reported = v + (0.5 * PLAY * np.gradient(gaussian_filter1d(stands, 2.0)) * RATE if along else 0.0)
    log = recorded(stands, noise=1e-4, velocity=reported)
    motion, jumps = seen(log)
    assert jumps is not None
    cleared = without_jumps(log, motion, {0: (jumps.size, jumps.course)})
    error = np.std((cleared.velocity[:, 0] - v)[200:-200])
    # By the noise of the position, or of the velocity: there is none on that.
    assert bool(error > 1e-3) is along
    assert error < 0.02
