"""A sliding joint whose columns are a turning joint's."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from mjfriction.diagnose.diagnosis import diagnose_log
from mjfriction.diagnose.tell.outcome import Diagnosis, Verdict
from mjfriction.record.log import Floats
from mjfriction.record.readers import read_log
from mjfriction.robot.files import read_robot
from tests.deep import deep
from tests.hidden.machine import Instant, Machine, write_case

SCARA = """
<mujoco>
  <compiler inertiafromgeom="false" angle="radian"/>
  <worldbody>
    <body name="upper">
      <joint name="shoulder" type="hinge" axis="0 0 1"/>
      <inertial pos="0.15 0 0" mass="8" diaginertia="0.05 0.1 0.1"/>
      <body name="lower" pos="0.3 0 0">
        <joint name="elbow" type="hinge" axis="0 0 1"/>
        <inertial pos="0.1 0 0" mass="5" diaginertia="0.03 0.05 0.05"/>
        <body name="spindle" pos="0.25 0 0">
          <joint name="quill" type="slide" axis="0 0 1" range="-0.15 0.15" limited="true"/>
          <inertial pos="0 0 0" mass="2" diaginertia="0.01 0.01 0.005"/>
          <body name="flange">
            <joint name="roll" type="hinge" axis="0 0 1"/>
            <inertial pos="0.03 0 0" mass="0.5" diaginertia="0.001 0.001 0.001"/>
          </body>
        </body>
      </body>
    </body>
  </worldbody>
</mujoco>
"""
JOINTS = ("shoulder", "elbow", "quill", "roll")


def stribeck(at: Instant) -> np.ndarray:
    return np.asarray(2.0 * np.exp(-((at.v / 0.1) ** 2)) * np.sign(at.v))


def diagnosed(folder: Path, quantities: tuple[str, ...], factor: float = 1.0, stroke: float = 0.08) -> Diagnosis:
    model = folder / "scara.xml"
    model.write_text(SCARA, encoding="utf-8")
    machine = Machine(
        model=model,
        joints=JOINTS,
        coulomb=(4.0, 3.0, 12.0, 0.4),
        viscous=(2.0, 1.0, 37.0, 0.13),
        reach=(1.0, 1.0, stroke, 1.3),
        hidden={1: stribeck},
    )
    path, robot = write_case(folder, machine, seed=4)
    log = read_log(path)
    exchanged: dict[str, Floats] = {}
    for quantity in quantities:
        one, other = (f"{quantity}.{joint}" for joint in ("quill", "roll"))
        exchanged |= {one: factor * log.columns[other], other: log.columns[one]}
    return diagnose_log(replace(log, columns={**log.columns, **exchanged}), read_robot(robot))


@pytest.mark.parametrize(
    # In a stroke of 16 mm, read as radians, a joint does not count as moving.
    ("quantities", "stroke"),
    [deep(("position",), 0.08), (("position", "effort"), 0.08), (("position",), 0.008)],
)
def test_columns_of_a_slide_and_a_turning_joint_that_are_exchanged_are_no_units(
    quantities: tuple[str, ...], stroke: float, tmp_path: Path
) -> None:
    found = diagnosed(tmp_path, quantities, stroke=stroke)
    assert found.verdict is Verdict.BAD_DATA
    assert [fault.kind for fault in found.faults] == ["data.swap"]
    assert ("all columns" in found.faults[0].where) == (len(quantities) > 1)
    (finding,) = found.findings
    assert (finding.cause, finding.joint) == ("friction.stribeck", "elbow")


def test_what_fits_in_no_place_is_of_another_unit_still(tmp_path: Path) -> None:
    found = diagnosed(tmp_path, ("position",), factor=20.0)
    assert (found.refused, [fault.kind for fault in found.faults]) == (True, ["data.unit"])
