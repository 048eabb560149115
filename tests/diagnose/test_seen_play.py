"""Play that the position itself shows: the sensor jumps, and whoever looks at efforts only takes that for blows."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest

import mjfriction.diagnose.diagnosis as module
from mjfriction.control.observe import observe_log
from mjfriction.diagnose.diagnosis import diagnose_log
from mjfriction.diagnose.tell.outcome import Verdict
from mjfriction.diagnose.tell.seen_play import SeenPlay, unseen
from mjfriction.identify.gap import Gap
from mjfriction.identify.measure import measure_gap
from mjfriction.record.log import Floats, Log
from mjfriction.record.readers import read_log
from mjfriction.record.readers.table import log_from_table
from mjfriction.robot.files import read_robot
from mjfriction.robot.predict import predict_log
from mjfriction.robot.robot import Robot
from tests.hidden.machine import UR5_JOINTS, Instant, Machine, write_case

WRIST, PLAY = 3, 2e-3


def jumping(instant: Instant) -> np.ndarray:
    return 0.5 * PLAY * np.sign(instant.rigid)


@pytest.fixture(scope="module")
def case(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    return write_case(tmp_path_factory.mktemp("loose"), Machine(sensed={WRIST: jumping}), seed=7)


def test_a_sensor_that_jumps_with_the_load_is_play(case: tuple[Path, Path]) -> None:
    log, stated = read_log(case[0]), read_robot(case[1])
    diagnosis = diagnose_log(log, stated)
    (finding,) = diagnosis.findings
    assert (finding.cause, finding.joint) == ("drive.backlash", "wrist_1_joint")
    (play,) = finding.parameters
    assert play.low < PLAY < play.high
    assert finding.gain.low > 0.3
    assert diagnosis.gap.rms(finding.without, WRIST) == pytest.approx(finding.gain.before, rel=0.05)
    assert diagnosis.verdict is Verdict.EXPLAINED
    # The extended robot has it, and a log of it is then as it should be.
    again = diagnose_log(log, diagnosis.robot)
    assert (again.verdict, again.findings) == (Verdict.CONSISTENT, ())
    assert again.joints[WRIST].rms_before < 1.1 * again.joints[WRIST].noise_floor


def test_a_joint_that_jumps_and_whose_effort_was_not_recorded_is_not_examined(case: tuple[Path, Path]) -> None:
    log, stated = read_log(case[0]), read_robot(case[1])
    silent = {name: values for name, values in log.columns.items() if name != f"effort.{UR5_JOINTS[WRIST]}"}
    diagnosis = diagnose_log(replace(log, columns=silent), stated)
    assert diagnosis.not_examined == (UR5_JOINTS[WRIST],)
    assert UR5_JOINTS[WRIST] not in {finding.joint for finding in diagnosis.findings}


@pytest.mark.deep
def test_jumps_that_accelerate_more_than_the_motion_does_are_seen(tmp_path: Path) -> None:
    # As they are logged they make the load of an upright axis, which is all inertia, turn the other way.
    pan, play = 0, 20e-3
    loose = Machine(sensed={pan: lambda at: 0.5 * play * np.sign(at.rigid)}, reach=(0.2, 1.0, 1.0, 1.0, 1.0, 1.0))
    log, robot = write_case(tmp_path, loose, seed=7)
    (finding,) = diagnose_log(read_log(log), read_robot(robot)).findings
    assert (finding.cause, finding.joint) == ("drive.backlash", UR5_JOINTS[pan])
    assert finding.parameters[0].value == pytest.approx(play, rel=0.02)


@pytest.mark.deep
def test_without_looking_at_the_position_it_is_missed(case: tuple[Path, Path], monkeypatch: pytest.MonkeyPatch) -> None:
    def blind(stated: Gap, highest: float) -> SeenPlay:
        return unseen(stated)

    monkeypatch.setattr(module, "see_play", blind)
    assert diagnose_log(read_log(case[0]), read_robot(case[1])).findings == ()


@pytest.mark.deep
def test_a_clean_velocity_beside_it_hides_nothing(tmp_path: Path) -> None:
    log, robot = write_case(tmp_path, Machine(sensed={WRIST: jumping}, velocity="clean"), seed=7)
    (finding,) = diagnose_log(read_log(log), read_robot(robot)).findings
    assert (finding.cause, finding.joint) == ("drive.backlash", "wrist_1_joint")


@pytest.mark.deep
def test_what_else_is_wrong_is_found_beside_it(tmp_path: Path) -> None:
    def stribeck(instant: Instant) -> np.ndarray:
        return 1.5 * np.sign(instant.v) * np.exp(-np.square(instant.v / 0.1))

    machine = Machine(sensed={WRIST: jumping}, hidden={WRIST: stribeck})
    log, robot = write_case(tmp_path, machine, seed=7)
    found = {(one.cause, one.joint) for one in diagnose_log(read_log(log), read_robot(robot)).findings}
    assert found == {("drive.backlash", "wrist_1_joint"), ("friction.stribeck", "wrist_1_joint")}


@pytest.mark.parametrize(("told", "column"), [(predict_log, "effort"), (observe_log, "friction")])
def test_what_is_told_of_a_log_knows_when_stated_play_was_crossed(
    told: Callable[[Log, Robot], dict[str, Floats]], column: str, case: tuple[Path, Path], tmp_path: Path
) -> None:
    stated = read_robot(case[1])
    own = stated.table.joint[WRIST]
    played = own.transmission.model_copy(update={"backlash": PLAY, "coasting": False})
    loose = stated.with_joint(own.model_copy(update={"transmission": played}))
    tight_log, _ = write_case(tmp_path, Machine(), seed=7)
    name = f"{column}.wrist_1_joint"
    expected = told(read_log(tight_log), stated)[name]
    off = [np.std((told(read_log(case[0]), robot)[name] - expected)[500:-500]) for robot in (stated, loose)]
    assert off[1] < 0.2 * off[0]


@pytest.mark.deep
def test_play_that_is_stated_otherwise_is_corrected(case: tuple[Path, Path]) -> None:
    stated = read_robot(case[1])
    own = stated.table.joint[WRIST]
    played = own.transmission.model_copy(update={"backlash": 1.5 * PLAY, "coasting": False})
    diagnosis = diagnose_log(read_log(case[0]), stated.with_joint(own.model_copy(update={"transmission": played})))
    (finding,) = diagnosis.findings
    assert finding.cause == "drive.backlash"
    assert diagnosis.robot.table.joint[WRIST].transmission.backlash == pytest.approx(PLAY, rel=0.01)


def test_a_log_that_is_refused_is_searched_for_no_play(case: tuple[Path, Path]) -> None:
    log = read_log(case[0])
    column = "effort.elbow_joint"
    wrong = {**log.columns, column: 37.0 * log.columns[column]}
    diagnosis = diagnose_log(replace(log, columns=wrong), read_robot(case[1]))
    assert (diagnosis.verdict, diagnosis.findings) == (Verdict.BAD_DATA, ())
    assert diagnosis.robot.table.joint[WRIST].transmission.backlash == 0.0


@pytest.mark.deep
@pytest.mark.parametrize("seed", [7, 8])
def test_jumps_that_take_some_milliseconds_are_taken_off_too(seed: int, tmp_path: Path) -> None:
    def slowly(instant: Instant) -> np.ndarray:
        return 2e-3 * np.tanh(instant.rigid / (0.02 * np.max(np.abs(instant.rigid))))

    log, robot = write_case(tmp_path, Machine(sensed={4: slowly}), seed=seed)
    diagnosis = diagnose_log(read_log(log), read_robot(robot))
    (finding,) = diagnosis.findings
    assert (finding.cause, finding.joint) == ("drive.backlash", "wrist_2_joint")
    assert finding.parameters[0].value == pytest.approx(4e-3, rel=0.15)
    assert diagnosis.joints[4].rms_heldout_after < 1.1 * diagnosis.joints[4].noise_floor


@pytest.mark.deep
@pytest.mark.parametrize("seed", [7, 8])
def test_play_that_is_crossed_little_by_little_is_found(seed: int, tmp_path: Path) -> None:
    def softly(instant: Instant) -> np.ndarray:
        return 1e-3 * np.tanh(instant.rigid / (0.05 * np.max(np.abs(instant.rigid))))

    log, robot = write_case(tmp_path, Machine(sensed={0: softly}), seed=seed)
    diagnosis = diagnose_log(read_log(log), read_robot(robot))
    (finding,) = diagnosis.findings
    assert (finding.cause, finding.joint) == ("drive.backlash", "shoulder_pan_joint")
    play, within = finding.parameters
    assert play.low < 2e-3 < play.high
    assert within.name == "crossing_load"
    assert not diagnosis.robot.table.joint[0].transmission.coasting
    assert diagnosis.joints[0].rms_heldout_after < 1.05 * diagnosis.joints[0].noise_floor


@pytest.mark.deep
def test_a_log_in_two_pieces_tells_the_same(case: tuple[Path, Path]) -> None:
    table = pq.read_table(case[0])
    rows = table.num_rows
    kept = np.r_[0 : rows // 2, rows // 2 + 100 : rows]
    log, stated = log_from_table(table.take(kept), "cut"), read_robot(case[1])
    (finding,) = diagnose_log(log, stated).findings
    assert finding.cause == "drive.backlash"
    assert measure_gap(log, diagnose_log(log, stated).robot).motion.jump_free == {WRIST}
