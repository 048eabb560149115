"""What is printed at a terminal: no more than can be believed."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np
import pyarrow as pa
import pytest
from rich.console import Console

from mjfriction.diagnose.diagnosis import diagnose_log
from mjfriction.diagnose.tell.outcome import Verdict
from mjfriction.identify.identification import identify_log
from mjfriction.record.readers.table import log_from_table
from mjfriction.report.html import identified_html, report_html
from mjfriction.report.identified import make_identified_report
from mjfriction.report.result import make_report
from mjfriction.report.text import print_identified, print_report
from mjfriction.report.write import save_diagnosis
from mjfriction.robot.files import read_robot
from mjfriction.robot.robot import Robot
from tests.hidden.machine import Machine, record, robot_toml

ERRORS = "RMS error on motion not fitted"


@pytest.fixture
def stated(tmp_path: Path) -> Robot:
    (tmp_path / "robot.toml").write_text(robot_toml(Machine()), encoding="utf-8")
    return read_robot(tmp_path / "robot.toml")


def console() -> Console:
    return Console(width=80, file=io.StringIO(), highlight=False)


def printed(console: Console) -> str:
    assert isinstance(console.file, io.StringIO)
    return console.file.getvalue()


LAST = "effort.wrist_3_joint"


@pytest.mark.parametrize(("factor", "refused"), [(1.0, False), (1000.0, False), (37.0, True)])
def test_a_log_that_is_refused_is_given_no_errors_to_believe(stated: Robot, factor: float, refused: bool) -> None:
    columns = dict(record(Machine(), 4, 12.0))
    columns[LAST] = factor * columns[LAST]
    diagnosis = diagnose_log(log_from_table(pa.table(columns), "log"), stated)
    assert (diagnosis.verdict is Verdict.BAD_DATA) is (factor != 1.0)
    report, terminal = make_report(diagnosis), console()
    print_report(report, terminal)
    page = report_html(diagnosis, report)
    assert ("data.unit" in printed(terminal)) is (factor != 1.0)
    titles = ("What the error follows", 'id="errors"', 'id="course-0"')
    for told, title in ((printed(terminal), ERRORS), *((page, one) for one in titles)):
        assert (title in told) is not refused, title


@pytest.mark.parametrize(("column", "factor"), [("effort.elbow_joint", -1.0), (LAST, 37.0)])
def test_what_was_not_fitted_is_not_called_extended_and_one_fault_is_told_once(
    stated: Robot, column: str, factor: float, tmp_path: Path
) -> None:
    columns = dict(record(Machine(), 4, 12.0))
    columns[column] = factor * columns[column]
    diagnosis = diagnose_log(log_from_table(pa.table(columns), "log"), stated)
    report, terminal = save_diagnosis(diagnosis, tmp_path / "result"), console()
    assert report.verdict == "bad_data"
    robot = (tmp_path / "result/robot.toml").read_text(encoding="utf-8")
    assert robot.startswith("# As stated: nothing was fitted to log." if factor > 0.0 else "# Extended by mjfriction")
    assert read_robot(tmp_path / "result").table.joint == stated.table.joint
    print_report(report, terminal)
    assert printed(terminal).count(column) == 1


@pytest.mark.parametrize("wave", [0.0, 3.0])
def test_a_law_that_does_not_hold_is_not_printed_as_one_that_does(stated: Robot, wave: float) -> None:
    log = record(Machine(noise=0.1, hidden={2: lambda i: wave * np.sin(7.0 * i.q)}), 11, 20.0)
    found = identify_log(log_from_table(pa.table(log), "log"), stated, law="coulomb_viscous")
    report, terminal = make_identified_report(found), console()
    print_identified(report, terminal)
    assert printed(terminal).startswith("IDENTIFIED, NOT EXPLAINED\n" if wave else "IDENTIFIED\n")
    assert ("the law does not hold here" in printed(terminal)) is bool(wave)
    assert ("identified, not explained" in identified_html(found, report)) is bool(wave)
