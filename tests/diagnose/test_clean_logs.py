"""A log the stated robot explains has no finding, however noisy and wherever its velocity comes from."""

from __future__ import annotations

from pathlib import Path

import pyarrow as pa
import pyarrow.parquet
import pytest

from mjfriction.diagnose.diagnosis import diagnose_log
from mjfriction.diagnose.outcome import Verdict
from mjfriction.record.readers import read_log
from mjfriction.robot.files import read_robot
from tests.hidden.closed_loop import record_closed_loop
from tests.hidden.machine import Machine, write_case


@pytest.mark.parametrize("velocity", ["none", "clean", "noisy"])
@pytest.mark.parametrize("noise", [0.0, 0.02, 0.1, 0.2, 0.5])
def test_no_finding(noise: float, velocity: str, tmp_path: Path) -> None:
    log, robot = write_case(tmp_path, Machine(noise=noise, velocity=velocity), seed=5)
    diagnosis = diagnose_log(read_log(log), read_robot(robot))
    assert diagnosis.findings == ()
    assert diagnosis.verdict is Verdict.CONSISTENT


@pytest.mark.parametrize("seed", range(6))
def test_no_finding_when_stated_friction_is_a_few_percent_off(seed: int, tmp_path: Path) -> None:
    log, robot = write_case(tmp_path, Machine(), seed=40 + seed, off=0.03)
    assert diagnose_log(read_log(log), read_robot(robot)).findings == ()


def test_joints_that_stick_and_break_loose_have_no_finding(tmp_path: Path) -> None:
    log = tmp_path / "log.parquet"
    pyarrow.parquet.write_table(record_closed_loop(31), log)
    diagnosis = diagnose_log(read_log(log), read_robot("ur5"))
    assert diagnosis.findings == ()
    assert diagnosis.verdict is Verdict.CONSISTENT


@pytest.mark.parametrize(
    ("pauses", "velocity"), [(False, "clean"), pytest.param(True, "none", marks=pytest.mark.bench)]
)
def test_bristles_of_an_ordinary_contact_are_no_finding(pauses: bool, velocity: str, tmp_path: Path) -> None:
    machine = Machine(bristle_travel=3e-4, pauses=pauses, velocity=velocity, noise=0.1)
    log, robot = write_case(tmp_path, machine, seed=6, off=0.03)
    assert diagnose_log(read_log(log), read_robot(robot)).findings == ()


def test_a_drive_that_reports_nothing_is_not_examined(tmp_path: Path) -> None:
    log, robot = write_case(tmp_path, Machine(), seed=4)
    table = pyarrow.parquet.read_table(log)
    place = table.schema.get_field_index("effort.wrist_3_joint")
    dead = table.set_column(place, "effort.wrist_3_joint", pa.array([0.0] * table.num_rows))
    pyarrow.parquet.write_table(dead, log)
    diagnosis = diagnose_log(read_log(log), read_robot(robot))
    assert diagnosis.not_examined == ("wrist_3_joint",)
    assert diagnosis.findings == ()
