"""Drives that report their efforts low-passed: predicted as they report, simulated alike, and found from a log."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pyarrow as pa
import pytest

from mjfriction.diagnose.diagnosis import diagnose_log
from mjfriction.identify import identification
from mjfriction.identify.identification import identify_log
from mjfriction.plant.machine import simulate
from mjfriction.plant.motions import excitation
from mjfriction.plant.sensors import Recorder
from mjfriction.record.log import Log
from mjfriction.record.low_pass import low_passed
from mjfriction.record.readers.table import log_from_table
from mjfriction.report.html import identified_html
from mjfriction.report.identified import make_identified_report
from mjfriction.report.result import make_report
from mjfriction.robot.files import read_robot, write_robot
from mjfriction.robot.predict import predict_log
from mjfriction.robot.robot import Robot
from tests.robot.test_friction_terms import URDF

RATE, SECONDS = 250.0, 40.0


def robot_with(folder: Path, coulomb: float, more: str = "") -> Robot:
    (folder / "one.urdf").write_text(URDF)
    (folder / "robot.toml").write_text(
        'name = "one"\nmodel = "one.urdf"\n[[joint]]\nname = "hinge"\n'
        f'friction = {{ law = "coulomb_viscous", parameters = {{ coulomb = {coulomb}, viscous = 0.8 }} }}\n{more}'
    )
    return read_robot(folder / "robot.toml")


def recorded(robot: Robot, seed: int = 4) -> Log:
    motion = excitation(("hinge",), np.zeros(1), np.ones(1), np.full(1, 3.0), SECONDS, seed=seed)
    return log_from_table(pa.table(simulate(robot, motion, recorder=Recorder(RATE), seed=seed)), "one")


def error(log: Log, robot: Robot) -> float:
    left = log.columns["effort.hinge"] - predict_log(log, robot)["effort.hinge"]
    return float(np.sqrt(np.nanmean(np.square(left))))


def test_the_low_pass_shifts_nothing_and_halves_at_its_band() -> None:
    time = np.arange(0.0, 20.0, 0.004)
    for frequency, gain in ((0.3, 1.0), (3.0, 0.5), (12.0, 0.0)):
        wave = np.sin(2.0 * np.pi * frequency * time)
        inner = slice(1000, 4000)
        np.testing.assert_allclose(low_passed(wave, 250.0, 3.0)[inner], gain * wave[inner], atol=0.01)


def test_a_simulation_reports_what_is_predicted(tmp_path: Path) -> None:
    slow = robot_with(tmp_path, 2.0, "effort_sensor = { bandwidth = 3.0 }\n")
    log = recorded(slow)
    plain = robot_with(tmp_path, 2.0)
    assert error(log, slow) < 0.1 * error(log, plain)  # every reversal is blurred


@pytest.mark.deep
def test_the_bandwidth_is_found_and_stated(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    machine = robot_with(tmp_path, 2.0, "effort_sensor = { bandwidth = 3.0, noise = 0.005 }\n")
    log, other = recorded(machine), recorded(machine, seed=5)
    stated = robot_with(tmp_path, 1.5)
    found = identify_log(log, stated, law="coulomb_viscous")
    assert found.bandwidths["hinge"] == pytest.approx(3.0, rel=0.05)
    assert found.laws[0].trusted
    (tmp_path / "out").mkdir()
    written = read_robot(write_robot(found.robot, tmp_path / "out"))
    diagnosed = diagnose_log(log, stated)
    for report in (make_identified_report(found), make_report(diagnosed)):
        assert "low-passed: hinge above 3" in report.low_passed
    report = make_identified_report(found)
    assert identified_html(found, report).count(report.low_passed) == 1
    assert diagnosed.bandwidths["hinge"] == pytest.approx(3.0, rel=0.05)
    assert diagnosed.robot.joint("hinge").effort_sensor.bandwidth == diagnosed.bandwidths["hinge"]
    assert not diagnose_log(log, diagnosed.robot).bandwidths  # what is stated is not stated anew
    monkeypatch.setattr(identification, "find_bandwidths", lambda *_: {})
    sharp = identify_log(log, stated, law="coulomb_viscous").robot
    # A filter's edge is where neither the machine nor the prediction is quite what it was; the truth does no better.
    assert error(other, written) < 1.02 * error(other, machine)
    assert error(other, sharp) > 3.0 * error(other, machine)


def test_an_effort_that_holds_all_has_no_bandwidth(tmp_path: Path) -> None:
    stated = robot_with(tmp_path, 1.5)
    log = recorded(robot_with(tmp_path, 2.0, "effort_sensor = { noise = 0.02 }\n"))
    found = identify_log(log, stated, law="coulomb_viscous")
    assert not found.bandwidths
    assert "low-passed" not in identified_html(found, make_identified_report(found))


TWO = """<mujoco><worldbody><body pos="0 0 0.3"><joint name="j1" axis="0 0 1"/>
  <inertial pos="0.1 0 0" mass="2" diaginertia=".01 .01 .01"/>
  <body pos="0.3 0 0"><joint name="j2" axis="0 1 0"/><inertial pos="0.1 0 0.02" mass="1" diaginertia=".01 .01 .01"/>
  </body></body></worldbody></mujoco>"""


def test_a_joint_that_sticks_at_its_reversals_has_no_bandwidth(tmp_path: Path) -> None:
    """Its friction turns over as slowly as its drive makes it, without noise to cover that up."""
    (tmp_path / "two.xml").write_text(TWO)
    laws = 'friction = { law = "coulomb_viscous", parameters = { coulomb = 1.0, viscous = 0.5 } }\n'
    joints = "".join(f'[[joint]]\nname = "{name}"\n{laws}' for name in ("j1", "j2"))
    (tmp_path / "robot.toml").write_text(f'name = "two"\nmodel = "two.xml"\n{joints}')
    robot = read_robot(tmp_path / "robot.toml")
    motion = excitation(("j1", "j2"), np.zeros(2), np.ones(2), np.full(2, 2.0), 20.0, seed=1)
    log = log_from_table(pa.table(simulate(robot, motion, recorder=Recorder(500.0))), "two")
    assert not identify_log(log, robot, law="coulomb_viscous").bandwidths
