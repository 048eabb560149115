"""Faults of the recording are found in the samples alone, mended, and said; sound recordings are left as they are."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pyarrow as pa
import pytest

from mjfriction.record import clipped as clipping
from mjfriction.record.clipped import clipped
from mjfriction.record.fault import in_words
from mjfriction.record.log import Log
from mjfriction.record.readers.table import log_from_table
from mjfriction.record.repeats import held_rows, repeated_rows
from mjfriction.record.stuck import frozen, stuck

RATE, COUNT = 500.0, 10_000
POSITION, EFFORT = "position.hinge", "effort.hinge"
Columns = dict[str, np.ndarray]


def recording(encoder_bits: int = 18, effort_step: float = 0.0) -> Columns:
    """A joint that swings, rests for two seconds and swings on, as an encoder and a noisy drive report it."""
    rng = np.random.default_rng(3)
    time = np.arange(COUNT) / RATE
    turn = 3.5 * np.pi / 1.3  # where the swing comes to rest by itself
    position = 0.8 * np.sin(1.3 * (time - np.clip(time - turn, 0.0, 2.0)))
    step = 2.0 * np.pi / 2**encoder_bits
    effort = 4.0 * np.cos(position) + np.sign(np.gradient(position)) + 0.1 * rng.normal(size=COUNT)
    if effort_step:
        effort = np.round(effort / effort_step) * effort_step
    return {"time": time, POSITION: np.round(position / step) * step, EFFORT: effort}


def read(columns: Columns) -> Log:
    return log_from_table(pa.table(columns), "log")


@pytest.mark.parametrize("encoder_bits", [10, 14, 20])
@pytest.mark.parametrize("effort_step", [0.0, 0.05])
def test_a_sound_recording_is_left_as_it_is(encoder_bits: int, effort_step: float) -> None:
    columns = recording(encoder_bits, effort_step)
    log = read(columns)
    assert log.faults == ()
    assert log.unusable == {}
    np.testing.assert_array_equal(log.columns[POSITION], columns[POSITION])
    np.testing.assert_array_equal(log.columns[EFFORT], columns[EFFORT])


def repeat(columns: Columns, *, clock_runs_on: bool) -> Columns:
    rows = np.r_[0:3000, 2800:COUNT]
    out = {name: values[rows] for name, values in columns.items()}
    if clock_runs_on:
        out["time"] = np.arange(rows.size) / RATE
    return out


def write_again(columns: Columns) -> Columns:
    rows = np.sort(np.r_[0:COUNT, 100, 700, 700, 701])
    return {name: values[rows] for name, values in columns.items()}


def write_few_again(columns: Columns) -> Columns:
    rows = np.r_[0:3000, 2996:COUNT]
    return {name: values[rows] for name, values in columns.items()}


def stick(columns: Columns) -> Columns:
    held = columns[POSITION].copy()
    held[2000:2300] = held[2000]
    return {**columns, POSITION: held}


def stall(columns: Columns) -> Columns:
    return {
        name: np.where((np.arange(COUNT) >= 2000) & (np.arange(COUNT) < 2030), own[2000], own)
        if name != "time"
        else own
        for name, own in columns.items()
    }


def freeze(columns: Columns) -> Columns:
    held = columns[EFFORT].copy()
    held[2000:2300] = held[2000]
    return {**columns, EFFORT: held}


def clip(columns: Columns, kept: float = 0.93) -> Columns:
    return {**columns, EFFORT: np.minimum(columns[EFFORT], np.quantile(columns[EFFORT], kept))}


def jolt(columns: Columns) -> Columns:
    wild = columns[POSITION].copy()
    wild[[1500, 6200]] += 0.4
    return {**columns, POSITION: wild}


@pytest.mark.parametrize(
    ("damage", "kind", "where"),
    [
        (lambda c: repeat(c, clock_runs_on=False), "data.duplicate", "5.6 s to 5.998 s (200 rows)"),
        (lambda c: repeat(c, clock_runs_on=True), "data.duplicate", "6 s to 6.398 s (200 rows)"),
        (write_again, "data.duplicate", "0.2 s, 1.4 s, 1.402 s (4 rows)"),
        (write_few_again, "data.duplicate", "5.992 s to 5.998 s (4 rows)"),
        (stall, "data.duplicate", "4.002 s to 4.058 s (29 rows)"),
        (stick, "data.stuck", f"{POSITION}, 4 s to 4.598 s"),
        (freeze, "data.stuck", f"{EFFORT}, 4 s to 4.598 s"),
        (clip, "data.saturation", EFFORT),
        (lambda c: clip(c, kept=0.35), "data.saturation", EFFORT),
        (jolt, "data.glitch", f"{POSITION}, 3 s, 12.4 s"),
    ],
    ids=[
        *("repeated", "repeated_later", "written_again", "few_again"),
        *("held", "stuck_position", "stuck_effort", "clipped", "mostly_clipped", "glitch"),
    ],
)
def test_a_fault_is_found_in_its_place(damage: Callable[[Columns], Columns], kind: str, where: str) -> None:
    log = read(damage(recording()))
    (fault,) = log.faults
    assert fault.kind == kind
    assert fault.where.startswith(where)


def test_rows_written_again_are_left_out_and_the_rest_stays_one_motion() -> None:
    whole = recording()
    log = read(write_again(whole))
    np.testing.assert_array_equal(log.time, whole["time"])
    np.testing.assert_array_equal(log.columns[EFFORT], whole[EFFORT])
    assert np.unique(log.segment).size == 1
    assert log.recorded is not None
    assert log.recorded.size == COUNT + 4


def test_a_coarse_sensor_that_flickers_between_its_counts_is_neither_stuck_nor_wild() -> None:
    # A servo with a 12-bit encoder, read a thousand times a second while it is moved, then held for most of the log.
    time, rng = np.arange(20000) / 1000.0, np.random.default_rng(5)
    position = 0.2 * np.sin(2.0 * np.minimum(time, 5.0)) + 2e-4 * rng.standard_normal(time.size)
    effort = 0.3 * np.sign(np.cos(2.0 * np.minimum(time, 5.0))) + 2e-4 * rng.standard_normal(time.size)
    count, level = 2.0 * np.pi / 4096, 0.02
    columns = {
        "time": time,
        POSITION: np.round(position / count) * count,
        EFFORT: np.round(effort / level) * level,
    }
    flicker = 9000 + 700 * np.arange(8)
    columns[EFFORT][flicker] += level  # a single count, now and then
    assert read(columns).faults == ()


def test_a_slow_joint_that_is_stuck_jumps_to_where_it_has_gone() -> None:
    # Slow beside its usual pace, so that nothing but the jump tells a stuck column from a rest.
    time = np.arange(4000) / RATE
    position = np.where(time < 4.0, np.cos(2.0 * time), np.cos(8.0) + 0.06 * (time - 4.0))
    speed = np.gradient(position, time)
    assert not np.any(stuck(position, speed))
    held = position.copy()
    held[3000:3400] = held[3000]
    assert np.flatnonzero(stuck(held, speed)).tolist() == list(range(3000, 3400))


def test_an_effort_that_is_frozen_while_its_joint_moves_and_rests() -> None:
    rng = np.random.default_rng(3)
    effort, moving = rng.normal(size=4000), np.arange(4000) % 1000 < 500
    assert not np.any(frozen(effort, moving))
    effort[1200:1800] = effort[1200]  # half of it in motion
    effort[3550:3900] = 0.0  # a rest, with the drive off
    assert np.flatnonzero(frozen(effort, moving)).tolist() == list(range(1200, 1800))


def test_an_effort_that_does_not_change_as_its_joint_sets_out_is_frozen_however_long_the_joint_rested() -> None:
    rng = np.random.default_rng(3)
    effort, moving = np.round(rng.normal(size=6000)), np.arange(6000) % 1000 < 200
    effort[1250:2150] = 1.0
    assert np.mean(moving[1250:2150]) < 0.3
    assert np.flatnonzero(frozen(effort, moving)).tolist() == list(range(1250, 2150))
    braked = np.round(rng.normal(size=6000))
    braked[1150:2000] = 1.0  # from the end of one motion to the beginning of the next
    assert not np.any(frozen(braked, moving))


def test_an_effort_that_is_noisy_at_rest_is_stuck_where_it_is_not() -> None:
    rng = np.random.default_rng(3)
    effort, moving = 2.0 + rng.normal(size=4000), np.arange(4000) < 1000
    effort[2000:2400] = effort[2000]
    assert np.flatnonzero(frozen(effort, moving)).tolist() == list(range(2000, 2400))
    held = np.where(moving, effort, 2.0)  # by a brake, whenever it rests
    assert not np.any(frozen(held, moving))


def test_what_is_mended_is_what_was_recorded() -> None:
    whole = recording()
    for damaged in (repeat(whole, clock_runs_on=False), jolt(whole)):
        log = read(damaged)
        np.testing.assert_allclose(log.time, whole["time"])
        np.testing.assert_allclose(log.columns[POSITION], whole[POSITION], atol=2e-3)


def test_nothing_is_differentiated_across_rows_left_out() -> None:
    log = read(stick(recording()))
    assert log.time.size == COUNT - 300
    before, after = (int(np.searchsorted(log.time, t)) for t in (3.99, 4.61))
    assert log.segment[after] == log.segment[before] + 1


def test_clipped_samples_are_marked_and_the_rest_is_not() -> None:
    columns = clip(recording())
    log = read(columns)
    np.testing.assert_array_equal(log.unusable[EFFORT], columns[EFFORT] == columns[EFFORT].max())


def test_a_machine_that_rests_repeats_its_rows_and_its_recorder_has_not_stalled() -> None:
    position = np.sin(np.clip(np.arange(4000) - 1000.0, 0.0, 2000.0) / 500.0)
    assert not np.any(held_rows({"position.a": position}))
    position[1500:1520] = position[1500]
    np.testing.assert_array_equal(np.flatnonzero(held_rows({"position.a": position})), np.arange(1501, 1520))


def test_few_coarse_rows_that_recur_are_no_copy_and_many_are() -> None:
    rng = np.random.default_rng(0)
    way = np.arange(40.0)
    coarse = np.concatenate([way, np.tile([40.0, 41.0], 6), way + 50.0, np.tile([40.0, 41.0], 6)])
    assert not np.any(repeated_rows({"a": coarse}))
    fine = rng.normal(size=40)
    np.testing.assert_array_equal(repeated_rows({"a": np.r_[fine, fine[5:20]]}), np.arange(55) >= 40)


def test_a_reading_that_stuck_once_at_its_highest_is_not_clipped() -> None:
    time = np.arange(6000) / 100.0
    effort = np.sin(2.0 * time) + 0.05 * np.random.default_rng(0).normal(size=time.size)
    moving = np.ones(time.size, dtype=bool)
    peak = int(np.argmax(effort))
    effort[peak : peak + 130] = effort[peak]
    assert not np.any(clipped(effort, moving))
    assert np.flatnonzero(frozen(effort, moving)).tolist() == list(range(peak, peak + 130))
    limited = np.minimum(effort, 0.9)  # a limit is left as it was reached
    assert np.all(clipped(limited, moving)[peak : peak + 130])


def test_a_coarse_reading_is_clipped_where_it_stands_at_its_extreme_more_than_beside_it() -> None:
    columns = recording(encoder_bits=20, effort_step=0.4)
    assert read(columns).unusable == {}
    most = 0.8 * np.max(columns[EFFORT])
    columns[EFFORT] = np.minimum(columns[EFFORT], np.round(most / 0.4) * 0.4)
    np.testing.assert_array_equal(read(columns).unusable[EFFORT], columns[EFFORT] == columns[EFFORT].max())


def test_a_very_coarse_reading_that_stands_still_at_its_extreme_alone_is_clipped() -> None:
    columns = recording()
    noisy = columns[EFFORT] + 0.7 * np.random.default_rng(8).normal(size=COUNT)
    coarse = np.round(noisy / 0.45) * 0.45
    limit = 0.6 * float(np.max(coarse))
    columns[EFFORT] = np.minimum(coarse, limit)
    log = read(columns)
    assert [fault.kind for fault in log.faults] == ["data.saturation"]
    np.testing.assert_array_equal(log.unusable[EFFORT], columns[EFFORT] == limit)
    # Stuck once, at its extreme or elsewhere, it is no limit.
    held = np.zeros(COUNT, dtype=bool)
    for first, past, value in ((1000, 1100, limit), (7000, 7100, 0.5 * limit)):
        held[first:past] = True
        columns[EFFORT][first:past] = value
    assert not np.any(clipping.stands_at_limits(columns[EFFORT], held))
    held[7000:7100] = False
    assert not np.any(clipping.stands_at_limits(columns[EFFORT], held))


@pytest.mark.parametrize(("lowest", "both"), [(-1.2, True), (-1.6, False)])
def test_a_drive_that_clips_one_way_clips_the_other_way_too(lowest: float, *, both: bool) -> None:
    # Coarse counts, of which many lie just above the lower limit and few below the upper one.
    below, above = np.repeat([lowest, lowest + 0.4, lowest + 0.8], [10, 40, 20]), np.repeat([0.4, 0.8, 1.2], [2, 1, 30])
    values = np.tile(np.concatenate([below, above]), 20)
    found = clipped(values, np.ones(values.size, dtype=bool))
    np.testing.assert_array_equal(found, (values == 1.2) | ((values == lowest) & both))


def test_a_quick_start_from_rest_is_no_stuck_sensor() -> None:
    columns = recording()
    time = columns["time"]
    going = np.clip(time - 6.0, 0.0, None)
    position = np.where(time < 4.0, 1.0 - np.cos(np.pi * time / 4.0), 2.0) + 0.4 * (1.0 - np.cos(4.0 * going))
    counts = 2.0 * np.pi / 2**15
    log = read({**columns, POSITION: np.round(position / counts) * counts})
    assert not any(fault.kind == "data.stuck" for fault in log.faults)


def test_rows_left_out_have_their_place_in_what_is_put_back() -> None:
    whole = recording()
    log = read(stick(whole))
    back = log.as_recorded(log.columns[EFFORT])
    np.testing.assert_array_equal(log.recorded, whole["time"])
    there = np.isfinite(back)
    assert np.count_nonzero(~there) == 300
    np.testing.assert_array_equal(back[there], whole[EFFORT][there])


def test_a_held_joint_that_gives_by_a_few_counts_is_no_stuck_sensor() -> None:
    time = np.arange(0.0, 20.0, 0.002)
    count = 5e-8
    held = np.zeros(time.size)
    held[4000:4400] = count
    held[9000:] = -3.0 * count
    columns = {"time": time, "position.mover": np.sin(time), "effort.mover": np.cos(time)}
    columns |= {"position.wrist": held, "effort.wrist": np.random.default_rng(0).normal(size=time.size)}
    assert np.any(stuck(held, np.gradient(held, time)))
    log = log_from_table(pa.table(columns), "log")
    assert log.faults == ()
    assert log.time.size == time.size


def rests_and_begins_elsewhere() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    # Two motions recorded one after the other: the first comes to rest, the second begins where the joint is by then.
    time = np.arange(4000) / RATE
    course = np.where(time < 2.0, np.sin(np.pi * np.minimum(time, 1.5) / 3.0), 0.4 + 0.3 * np.sin(2.0 * (time - 2.0)))
    return time, course, (time >= 2.0).astype(np.int64)


def test_where_one_motion_ends_and_another_begins_nothing_is_stuck() -> None:
    time, course, segment = rests_and_begins_elsewhere()
    speed = np.where(np.diff(segment, append=1) == 0, np.gradient(course, time), 0.0)
    assert not np.any(stuck(course, speed, segment))
    # The same in one motion is a reading that stuck, and then is elsewhere at once.
    assert np.any(stuck(course, speed))
    rows = {"position.a": course, "effort.a": np.where(course == 1.0, 2.0, 3.0 * course)}
    assert not np.any(held_rows(rows, segment))
    assert np.any(held_rows(rows))


@pytest.mark.parametrize("pause", [0.0, 3.0])
def test_motions_a_segment_or_a_gap_apart_are_told_of_no_stuck_reading(pause: float) -> None:
    time, course, segment = rests_and_begins_elsewhere()
    noise = 1e-2 * np.random.default_rng(2).standard_normal((2, time.size))
    columns = {"time": time + pause * segment, POSITION: course, EFFORT: 3.0 * course + noise[0]}
    if not pause:
        columns["segment"] = segment
    assert read(columns).faults == ()


def test_a_joint_that_sticks_stops_at_once_and_is_not_stuck() -> None:
    # Every pass ends in friction, within a sample, and begins as its drive winds up; the encoder is coarse.
    count, time = 4e-4, np.arange(20000) / RATE
    phase = time % 2.0
    pace = 0.15 * np.clip(2.0 * phase, 0.0, 1.0) * (phase < 1.5) * np.where(time % 4.0 < 2.0, 1.0, -1.0)
    course = np.round(np.cumsum(pace) / RATE / count) * count
    assert not np.any(stuck(course, np.diff(course, append=course[-1]) * RATE))


def test_a_recorder_that_stalls_is_known_in_rows_that_come_in_bursts() -> None:
    sampled = np.arange(4000) / RATE
    stamped = np.floor(sampled * RATE / 10.0 + 1.0) * 10.0 / RATE + 1e-6 * (np.arange(4000) % 10)
    noise = 0.1 * np.random.default_rng(4).standard_normal((2, 4000))
    rows = {"position.a": np.sin(3.0 * sampled) + 1e-4 * noise[0], "effort.a": noise[1]}
    for values in rows.values():
        values[2000:2060] = values[2000]
    log = log_from_table(pa.table({"time": stamped, **rows}), "log")
    assert "data.duplicate" in {fault.kind for fault in log.faults}
    assert log.time.size < 3950


@pytest.mark.parametrize("works_on", [True, False])
def test_a_joint_that_stops_at_once_and_rests_to_the_end_is_not_stuck_where_its_effort_rests_too(
    *, works_on: bool
) -> None:
    # A passage at one speed that friction ends within a sample; or a reading that stays there while the joint goes on.
    time = np.arange(COUNT) / RATE
    course = np.minimum(0.3 * time, 0.3 * 8.0)
    rng = np.random.default_rng(4)
    swings = np.where((time < 8.0) | works_on, np.cos(1.7 * time), 0.2)
    log = read({"time": time, POSITION: course, EFFORT: 2.0 * swings + 0.1 * rng.normal(size=COUNT)})
    assert [fault.kind for fault in log.faults] == (["data.stuck"] if works_on else [])


def test_a_reading_that_is_stuck_for_no_longer_than_the_joint_usually_rests_is_known_by_where_it_comes_loose() -> None:
    time = np.arange(COUNT) / RATE
    phase = time % 2.0
    pace = np.where(phase < 1.0, 0.4 * np.sin(np.pi * phase) ** 2, 0.0) * np.where(time % 4.0 < 2.0, 1.0, -1.0)
    course = np.cumsum(pace) / RATE
    assert not np.any(stuck(course, pace))
    course[4100:4400] = course[4100]
    assert np.flatnonzero(stuck(course, pace)).tolist() == list(range(4100, 4400))


def test_a_reading_that_turns_about_at_rest_comes_loose_by_usual_steps() -> None:
    count, time = 2e-3, np.arange(COUNT) / RATE
    pace = np.where(time < 8.0, 2.0, 0.0) - np.where(time > 9.0, 2.0, 0.0)
    course = np.round(np.cumsum(pace) / RATE / count) * count
    assert not np.any(stuck(course, np.diff(course, append=course[-1]) * RATE))
    course[time > 9.0] -= 0.016  # it was not at rest, but on its way, by as far as no longer seems a jump
    assert np.any(stuck(course, np.diff(course, append=course[-1]) * RATE))


def test_noise_that_is_cut_off_for_long_is_clipped_though_much_lies_beside(monkeypatch: pytest.MonkeyPatch) -> None:
    # Friction that grows with speed: clipped at its most, and read in counts of which the limit is none.
    speed = np.abs(np.sin(np.arange(COUNT) / 700.0))
    friction = np.where(np.arange(COUNT) % 2500 < 1250, 0.3, -0.3) - 0.3 * speed**40
    values = np.round((friction + 0.04 * np.random.default_rng(1).normal(size=COUNT)) / 0.0221) * 0.0221
    values = np.clip(values, -0.4191, 0.4191)
    moving = np.ones(COUNT, dtype=bool)
    np.testing.assert_array_equal(clipped(values, moving), values == -0.4191)
    monkeypatch.setattr(clipping, "OUTLASTS", np.inf)
    assert not np.any(clipped(values, moving))


def test_moments_of_a_clock_that_counts_since_1970_are_told_apart() -> None:
    assert in_words([(1700020043.5202, 1700020044.0)]) == "1700020043.520 s to 1700020044.000 s"
    assert in_words([(43.5202, 43.5202)]) == "43.5202 s"


def test_an_effort_that_is_clipped_while_its_joint_is_held_is_clipped_all_the_same() -> None:
    columns = recording()
    noise = 0.1 * np.random.default_rng(7).normal(size=COUNT)
    held = {"position.held": np.zeros(COUNT), "effort.held": np.clip(noise, -0.08, 0.08)}
    assert [(fault.kind, fault.where[:11]) for fault in read(columns | held).faults] == [
        ("data.saturation", "effort.held")
    ]
    assert read(columns | held | {"effort.held": noise}).faults == ()


@pytest.mark.parametrize("rest", [0.1, 0.4, 2.0])
def test_a_joint_that_rests_under_its_load_is_not_stuck(rest: float) -> None:
    time = np.arange(COUNT) / RATE
    stop = time[-1] - rest
    course = np.minimum(0.3 * time, 0.3 * stop)
    effort = 50.0 + np.where(time < stop, 8.0 * np.cos(1.7 * time), 0.0)
    effort += 0.1 * np.random.default_rng(4).normal(size=COUNT)
    assert read({"time": time, POSITION: course, EFFORT: effort}).faults == ()


def test_a_reading_that_comes_loose_where_it_stuck_is_known_by_its_velocity() -> None:
    time = np.arange(COUNT) / RATE
    course, velocity = np.sin(1.3 * time), 1.3 * np.cos(1.3 * time)
    held = course.copy()
    held[4000:6416] = course[4000]  # a whole period
    assert np.flatnonzero(stuck(held, velocity))[[0, -1]].tolist() == [4000, 6415]


def test_the_few_counts_of_a_held_joints_effort_are_not_clipped() -> None:
    columns = recording()
    flicker = 0.05 * (np.random.default_rng(8).random(COUNT) < 0.3)
    assert read(columns | {"position.held": np.zeros(COUNT), "effort.held": flicker}).faults == ()


def test_a_gap_beside_a_glitch_is_a_gap() -> None:
    columns = recording()
    columns[EFFORT][2999] += 50.0
    kept = np.r_[0:3000, 3500:COUNT]
    log = read({name: values[kept] for name, values in columns.items()})
    (glitch,) = log.faults
    assert (glitch.kind, glitch.spans) == ("data.glitch", ())


@pytest.mark.parametrize("most", [np.inf, 0.13])
def test_coarse_noise_that_heaps_up_at_both_extremes_is_clipped(most: float) -> None:
    # A slow effort within loud noise, in steps of a fortieth of its range: no run at the limit is long.
    rng, step = np.random.default_rng(6), 0.0065
    slow = 0.12 * np.sin(np.linspace(0.0, 40.0, 8000))
    bound = np.floor(most / step) * step if np.isfinite(most) else np.inf
    values = np.round(np.clip(slow + 0.03 * rng.normal(size=8000), -bound, bound) / step) * step
    found = clipped(values, np.ones(values.size, dtype=bool))
    expected = np.abs(values) > bound - 0.5 * step if np.isfinite(bound) else np.zeros(values.size, dtype=bool)
    np.testing.assert_array_equal(found, expected)


@pytest.mark.deep
def test_what_swings_or_rubs_in_coarse_counts_is_not_clipped() -> None:
    phase = np.linspace(0.0, 60.0, 8000)
    for counts in [*np.arange(8.0, 80.0, 0.37), 200.0, 1000.3]:
        for values in (
            np.round(counts * np.cos(phase)),
            np.round(counts * (np.cos(phase) + 0.4 * np.sign(np.cos(phase)))),
        ):
            assert not np.any(clipped(values, np.ones(values.size, dtype=bool))), counts


def test_the_noise_of_a_held_joints_velocity_moves_nothing() -> None:
    # Its encoder goes on by one coarse count in the end, as what holds it gives.
    columns, rng = recording(), np.random.default_rng(8)
    held = np.where(columns["time"] < 16.0, 0.0, 0.05)
    noise = {"velocity.held": 1e-3 * rng.normal(size=COUNT), "effort.held": 0.1 * rng.normal(size=COUNT)}
    log = read(columns | {"position.held": held} | noise)
    assert "data.stuck" not in {fault.kind for fault in log.faults}
    assert log.time.size == COUNT
    speed = noise["velocity.held"]
    assert np.any(stuck(held, speed))
    assert not np.any(stuck(held, speed, course=np.cumsum(speed) / RATE))


@pytest.mark.parametrize("hidden", [0.01, 0.001, 0.0])  # fifty and five of the steps beside
@pytest.mark.parametrize("rests", [False, True])
def test_a_slow_joint_that_is_stuck_makes_a_step_like_no_other_beside_it(rests: bool, hidden: float) -> None:
    """Quick elsewhere in the log, so that neither its speed nor the size of the step tells; rests may be as long."""
    time = np.arange(6000) / RATE
    quick = 0.4 * np.cos(15.0 * np.minimum(time, 4.0))
    before = np.zeros(0)
    if rests:
        move = 0.2 * (1.0 - np.cos(np.pi * np.linspace(0.0, 1.0, 200)))
        before = np.concatenate(
            [np.append(move if k % 2 else move[::-1], np.full(350, 0.4 * (k % 2))) for k in range(12)]
        )
    position = np.concatenate([before, quick + 0.1 * np.clip(time - 4.0, 0.0, 3.0)])
    a, b = before.size + 3000, before.size + 3400
    assert not np.any(stuck(position, np.gradient(position, 1.0 / RATE)))
    held = position.copy()
    held[a:b] = held[a]
    held[b:] += held[a] + hidden - held[b]
    assert held[b] - held[a] < np.max(np.abs(np.diff(position)))
    assert np.any(stuck(held, np.gradient(held, 1.0 / RATE))[a:b]) is np.bool_(hidden > 0.005)
