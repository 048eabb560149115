"""What people see of a diagnosis: pictures that show a cause before and nothing after, and a recording of it all."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import plotly.graph_objects as go
import pytest

from mjfriction.diagnose.diagnosis import diagnose_log
from mjfriction.diagnose.tell.outcome import Diagnosis
from mjfriction.record.readers import read_log
from mjfriction.report.figures import INK, thinned, time_course
from mjfriction.report.finding_figure import finding_figure
from mjfriction.report.rerun_view import thinned_to_see, write_recording
from mjfriction.report.result import make_report
from mjfriction.robot.files import read_robot
from tests.hidden.machine import UR5_COULOMB, Instant, Machine, bristle, write_case
from tests.report.recordings import entities


def late(i: Instant) -> np.ndarray:
    whole = i.rigid + i.friction
    return np.interp(i.time - 0.03, i.time, whole) - whole


@pytest.fixture(scope="module")
def diagnosis(tmp_path_factory: pytest.TempPathFactory) -> Diagnosis:
    machine = Machine(
        hidden={
            0: lambda i: 2.5 * np.cos(14.0 * i.q),
            1: late,
            2: lambda i: 2.0 * (i.time > 16.0) * np.sign(i.v) + 2.5 * i.v * np.abs(i.v),
            3: lambda i: UR5_COULOMB[3] * (bristle(i.q, 0.03) - np.sign(i.v)),
            4: lambda i: 0.7 * np.sin(8.0 * i.q) * np.sign(i.v),
        }
    )
    log, robot = write_case(tmp_path_factory.mktemp("case"), machine, seed=5, seconds=30.0)
    return diagnose_log(read_log(log), read_robot(robot))


def drawn(diagnosis: Diagnosis, cause: str) -> go.Figure:
    (finding,) = [one for one in diagnosis.findings if one.cause == cause]
    return finding_figure(diagnosis, finding)


def means(figure: go.Figure) -> list[tuple[np.ndarray, np.ndarray]]:
    return [(np.array(line.x), np.array(line.y)) for line in figure.data if line.mode == "lines"]


@pytest.mark.parametrize(("cause", "wavenumber"), [("drive.cogging", 14.0), ("friction.position", 8.0)])
def test_waves_as_a_spectrum(diagnosis: Diagnosis, cause: str, wavenumber: float) -> None:
    (waves, before), (_, after) = means(drawn(diagnosis, cause))
    assert waves[np.argmax(before)] == pytest.approx(wavenumber, abs=1.5 * (waves[1] - waves[0]))
    assert np.max(after) < 0.15 * np.max(before)


def test_a_build_up_against_the_travel_since_the_turn(diagnosis: Diagnosis) -> None:
    (travel, before), (_, after) = means(drawn(diagnosis, "friction.presliding"))
    early = travel < 0.02
    assert np.mean(before[early]) < -0.5 * UR5_COULOMB[3]
    assert np.max(np.abs(before[travel > 0.2])) < 0.1 * UR5_COULOMB[3]
    assert np.max(np.abs(after)) < 0.15 * UR5_COULOMB[3]


def test_a_step_along_time_in_the_direction_of_friction(diagnosis: Diagnosis) -> None:
    # The damping that bends at the same joint is another finding's, so that this picture is without it.
    (time, before), (_, after) = means(drawn(diagnosis, "event.change"))
    stated = diagnosis.gap.residual[:, 2] * diagnosis.gap.at_rows("forward")[:, 2]
    early = diagnosis.gap.clear[:, 2] & (diagnosis.gap.chain.time < 15.5)
    assert np.mean(stated[early]) > 0.3
    assert np.max(np.abs(before[time < 15.5])) < 0.3
    assert np.min(before[time > 16.5]) > 1.5
    assert np.max(np.abs(after)) < 0.5


def test_a_delay_as_a_loop_that_closes(diagnosis: Diagnosis) -> None:
    loops = means(drawn(diagnosis, "sensor.delay"))[1::2]  # each beside its diagonal
    wide = [float(np.std(measured - predicted)) for predicted, measured in loops]
    assert wide[1] < 0.3 * wide[0]


def test_errors_that_do_not_count_are_grey_and_set_no_axis(diagnosis: Diagnosis) -> None:
    figure = time_course(diagnosis, "shoulder_lift_joint", "extended")
    clear = diagnosis.gap.clear[:, 1]
    (low, high) = figure.layout.yaxis2.range
    stated = np.abs(diagnosis.gap.residual[:, 1])
    assert 0.0 < high == -low
    assert np.max(stated[~clear]) > high > np.quantile(stated[clear], 0.99)
    errors = [line for line in figure.data if line.yaxis == "y2"]
    grey, counted = errors[0::2], errors[1::2]
    assert {line.line.color for line in grey} == {INK}
    assert INK not in {line.line.color for line in counted}
    kept = thinned(clear.size)
    for line, own in ((grey[0], ~clear[kept]), (counted[0], clear[kept])):
        np.testing.assert_array_equal(np.isfinite(np.array(line.y, dtype=float)), own)


def test_a_recording_shows_arm_efforts_friction_and_bristles(diagnosis: Diagnosis, tmp_path: Path) -> None:
    path = tmp_path / "recording.rrd"
    write_recording(diagnosis, make_report(diagnosis), path)
    found = entities(path)
    for joint in diagnosis.gap.robot.joints:
        pairs = [f"{course}/{name}" for course in ("torque", "error", "driven") for name in ("stated", "extended")]
        for name in ("torque/measured", *pairs):
            assert f"/{joint}/{name}" in found
        assert {f"/{joint}/friction/{name}" for name in ("measured", "stated", "extended")} <= found
        assert f"/{joint}/current/measured" not in found  # no torque constant is stated
    assert {"/findings", "/robot/forearm_link", "/wrist_1_joint/state/dahl/1"} <= found
    assert not any(name.startswith("/elbow_joint/state") for name in found)
    driven = diagnosis.gap.robot.joint("elbow_joint")
    actuator = driven.actuator.model_copy(update={"torque_constant": 0.1})
    robot = diagnosis.gap.robot.with_joint(driven.model_copy(update={"actuator": actuator}))
    gap = replace(diagnosis.gap, robot=robot)
    write_recording(replace(diagnosis, gap=gap, free_run=None), make_report(diagnosis), path)
    names = {f"/elbow_joint/current/{name}" for name in ("measured", "stated", "extended")}
    assert names <= entities(path)
    assert not any("/driven/" in name for name in entities(path)), "nothing was driven"


def test_long_recordings_are_thinned() -> None:
    for seconds, rate, most in ((60.0, 1000.0, 12_001), (600.0, 1000.0, 40_000), (5.0, 100.0, 501)):
        time = np.arange(int(seconds * rate) + 1) / rate
        kept = time[thinned_to_see(time)]
        assert most / 2 < kept.size <= most
