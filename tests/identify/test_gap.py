"""The gap between a log and a robot where a log has less than all."""

from __future__ import annotations

from dataclasses import replace
from importlib.resources import files
from pathlib import Path

import numpy as np
import pytest

from mjfriction.diagnose.diagnosis import diagnose_log
from mjfriction.identify.gap import measure_gap
from mjfriction.record.log import Log
from mjfriction.record.readers import read_log
from mjfriction.robot.files import read_robot


@pytest.fixture(scope="module")
def demo() -> Log:
    return read_log(Path(str(files("mjfriction"))) / "bundled/demo/log.parquet")


def test_a_joint_that_reads_the_same_throughout_is_no_obstacle(demo: Log) -> None:
    still = {**demo.columns, "position.wrist_3_joint": np.zeros(demo.time.size)}
    gap = measure_gap(replace(demo, columns=still), read_robot("ur5"))
    assert not gap.motion.moving[5]
    assert np.all(np.isfinite(gap.doubt))


def test_a_link_whose_joint_reports_no_effort_is_felt_by_the_others(demo: Log) -> None:
    columns = {name: values for name, values in demo.columns.items() if name != "effort.wrist_1_joint"}
    robot = read_robot("ur5")
    light = robot.table.model_copy(update={"link_scale": {"wrist_1_joint": 0.5}})
    found = diagnose_log(replace(demo, columns=columns), replace(robot, table=light))
    assert ("body.link_inertia", None) in {(finding.cause, finding.joint) for finding in found.findings}
    assert "wrist_1_joint" in found.not_examined
