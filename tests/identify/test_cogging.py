"""Cogging from passes: waves that friction, of any law, stays out of."""

from __future__ import annotations

import numpy as np
import pyarrow as pa
import pytest

from mjfriction.errors import LogError
from mjfriction.identify.cogging import cogging_waves, harmonics
from mjfriction.identify.friction_course import FrictionCourse, friction_course
from mjfriction.identify.phases import Phase, constant_speed_phases
from mjfriction.plant.machine import simulate
from mjfriction.plant.motions import forward_backward
from mjfriction.plant.sensors import Recorder
from mjfriction.record.readers.table import log_from_table
from mjfriction.robot.files import read_robot
from mjfriction.robot.robot import Robot


def blank() -> Robot:
    table = read_robot("machine_table")
    return table.with_joint(table.joint("axis").model_copy(update={"cogging": ()}))


@pytest.fixture(scope="module")
def course() -> tuple[FrictionCourse, list[Phase]]:
    passes = forward_backward("axis", -0.03, 0.06, [0.01, 0.02, 0.03], 0.2)
    columns = simulate(read_robot("machine_table"), passes, recorder=Recorder(500.0), seed=3)
    found = friction_course(log_from_table(pa.table(columns), "passes"), blank(), "axis")
    return found, constant_speed_phases(found.motion)


def test_the_machines_waves_are_found_and_no_others(course: tuple[FrictionCourse, list[Phase]]) -> None:
    found = cogging_waves(*course, harmonics(0.05, 30).tolist(), 0.1)
    true = read_robot("machine_table").joint("axis").cogging
    assert [round(wave.wavenumber * 0.05 / (2.0 * np.pi)) for wave in found] == [8, 16, 24]
    for one, other in zip(found, true, strict=True):
        assert np.hypot(one.cosine - other.cosine, one.sine - other.sine) < 0.03 * np.hypot(3.2, 1.9)


def test_friction_is_left_when_the_waves_are_known(course: tuple[FrictionCourse, list[Phase]]) -> None:
    whole, phases = course
    row = slice(phases[0].first, phases[0].past)
    waves = cogging_waves(*course, harmonics(0.05, 30).tolist(), 0.1)
    cogging = sum(
        wave.cosine * np.cos(wave.wavenumber * whole.position[row])
        + wave.sine * np.sin(wave.wavenumber * whole.position[row])
        for wave in waves
    )
    assert np.std(whole.friction[row] - cogging) < 0.1 * np.std(whole.friction[row])


def test_passes_one_way_tell_nothing(course: tuple[FrictionCourse, list[Phase]]) -> None:
    whole, phases = course
    with pytest.raises(LogError, match="passes in both directions"):
        cogging_waves(whole, [phase for phase in phases if phase.velocity > 0.0], [1000.0])


def test_a_short_stroke_does_not_tell_long_waves_apart(course: tuple[FrictionCourse, list[Phase]]) -> None:
    whole, phases = course
    with pytest.raises(LogError, match="go over more of the stroke"):
        cogging_waves(whole, phases, [1000.0, 1000.0])
