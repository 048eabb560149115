"""What a log is said to show, it shows; and what is far smaller it does not."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pyarrow as pa
import pytest

from mjfriction.diagnose.diagnosis import diagnose_log
from mjfriction.diagnose.tell.visible import visible_causes
from mjfriction.identify.measure import measure_gap
from mjfriction.record.readers.table import log_from_table
from mjfriction.robot.files import read_robot
from tests.hidden.machine import Effect, Instant, Machine, record, robot_toml

ELBOW = 2
EFFECTS = {
    "drive.offset": lambda i: np.ones_like(i.v),
    "friction.load": lambda i: np.abs(i.rigid) * np.sign(i.v),
    "friction.asymmetry": lambda i: np.abs(i.v),
    "drive.cogging": lambda i: np.cos(12.0 * i.q),
}


def hidden(effect: Effect, size: float) -> Effect:
    def scaled(instant: Instant) -> np.ndarray:
        values = effect(instant)
        return size * values / np.sqrt(np.mean(np.square(values)))

    return scaled


@pytest.mark.deep
@pytest.mark.parametrize(
    "cause", [pytest.param(name, marks=[pytest.mark.deep] * (name != "friction.load")) for name in sorted(EFFECTS)]
)
def test_what_is_said_to_show_shows(cause: str, tmp_path: Path) -> None:
    (tmp_path / "robot.toml").write_text(robot_toml(Machine()), encoding="utf-8")
    robot = read_robot(tmp_path / "robot.toml")

    def log_with(size: float):
        machine = Machine(hidden={ELBOW: hidden(EFFECTS[cause], size)})
        return log_from_table(pa.table(record(machine, 8, 30.0)), "log")

    gap = measure_gap(log_with(0.0), robot)
    (least,) = (one for one in visible_causes(gap) if one.cause == cause and one.joint == "elbow_joint")
    named = [
        cause in {finding.cause for finding in diagnose_log(log_with(factor * least.size), robot).findings}
        for factor in (0.2, 3.0)
    ]
    assert named == [False, True]


def test_a_joint_with_many_small_errors_shows_only_what_stands_out_of_them(tmp_path: Path) -> None:
    (tmp_path / "robot.toml").write_text(robot_toml(Machine()), encoding="utf-8")

    def ripple(at: Instant) -> np.ndarray:
        return 0.8 * (np.sin(61.0 * at.q) + np.sin(43.0 * at.q) * np.sign(at.v))

    log = log_from_table(pa.table(record(Machine(hidden={ELBOW: ripple}, noise=0.01), 8, 20.0)), "log")
    gap = measure_gap(log, read_robot(tmp_path / "robot.toml"))
    left = gap.rms(gap.residual[:, ELBOW], ELBOW)
    own = {one.cause: one.size for one in visible_causes(gap) if one.joint == "elbow_joint"}
    assert own["drive.offset"] > 0.8 * left
    assert own["friction.asymmetry"] > 0.8 * left


def test_a_joint_that_stands_still_shows_nothing_of_its_friction(tmp_path: Path) -> None:
    (tmp_path / "robot.toml").write_text(robot_toml(Machine()), encoding="utf-8")
    columns = dict(record(Machine(), 8, 20.0))
    columns["position.wrist_3_joint"] = np.full_like(columns["time"], columns["position.wrist_3_joint"][0])
    gap = measure_gap(log_from_table(pa.table(columns), "log"), read_robot(tmp_path / "robot.toml"))
    shown = {one.cause for one in visible_causes(gap) if one.joint == "wrist_3_joint"}
    assert not {cause for cause in shown if cause.startswith("friction.")}
