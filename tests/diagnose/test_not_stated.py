"""Friction that a robot file does not state at all is told, whatever else its joint has."""

from __future__ import annotations

from pathlib import Path

import pytest

from mjfriction.diagnose import stated
from mjfriction.diagnose.diagnosis import diagnose_log
from mjfriction.record.readers import read_log
from mjfriction.robot.files import read_robot
from tests.hidden.machine import UR5_COULOMB, UR5_JOINTS, UR5_VISCOUS, Machine, write_case

ELBOW = 2


def told(folder: Path) -> set[tuple[str, str | None]]:
    machine = Machine(hidden={ELBOW: lambda at: -3.0 * at.v * abs(at.v)}, noise=0.1)
    log, robot = write_case(folder, machine, seed=5)
    text = robot.read_text(encoding="utf-8")
    own = f"coulomb = {UR5_COULOMB[ELBOW]}, viscous = {UR5_VISCOUS[ELBOW]}"
    assert own in text
    robot.write_text(text.replace(own, "coulomb = 0.0, viscous = 0.0"), encoding="utf-8")
    return {(finding.cause, finding.joint) for finding in diagnose_log(read_log(log), read_robot(robot)).findings}


def test_it_is_told_beside_a_bend_over_speed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    level, bend = ("friction.coulomb_viscous", UR5_JOINTS[ELBOW]), ("friction.viscous_nonlinear", UR5_JOINTS[ELBOW])
    assert told(tmp_path / "told") == {level, bend}
    monkeypatch.setattr(stated, "AS_MUCH", float("inf"))
    assert told(tmp_path / "bent") == {bend}
