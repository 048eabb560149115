"""Efforts whose noise a drive low-passed: little of it is left beyond the pass band, and what is within is no cause."""

from __future__ import annotations

from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from scipy.signal import butter, sosfiltfilt

from mjfriction.diagnose.diagnosis import diagnose_log
from mjfriction.diagnose.tell import verdict
from mjfriction.diagnose.tell.outcome import Diagnosis, Verdict
from mjfriction.record.readers import read_log
from mjfriction.robot.files import read_robot
from tests.hidden.machine import UR5_JOINTS, Machine, record, robot_toml

RATE, CUTOFF = 250.0, 25.0  # Hz


def diagnosed(folder: Path) -> Diagnosis:
    machine = Machine(noise=1.5)
    columns = record(machine, seed=6, rate=RATE)
    sos = butter(2, CUTOFF, fs=RATE, output="sos")
    for joint in UR5_JOINTS:
        columns[f"effort.{joint}"] = sosfiltfilt(sos, columns[f"effort.{joint}"])
    folder.mkdir()
    pq.write_table(pa.table(columns), folder / "log.parquet")
    (folder / "robot.toml").write_text(robot_toml(machine), encoding="utf-8")
    return diagnose_log(read_log(folder / "log.parquet"), read_robot(folder / "robot.toml"))


@pytest.mark.deep
def test_it_is_nothing_that_is_left_unexplained(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    found = diagnosed(tmp_path / "told")
    assert found.findings == ()
    assert found.verdict is Verdict.CONSISTENT
    # The sensor's noise, as it is beyond the pass band, is less than a fifth of what is left.
    assert min(error.rms_after / error.noise_floor for error in found.joints) > verdict.FAR_ABOVE_NOISE
    monkeypatch.setattr(verdict, "MUCH_COLOURED", -1.0)
    assert diagnosed(tmp_path / "blamed").verdict is Verdict.UNEXPLAINED
