"""A gantry: what is held at its end and its last carriage weigh the same wherever it goes."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import mujoco
import numpy as np
import pytest

from mjfriction.diagnose.causes.cause import Site
from mjfriction.diagnose.causes.links import LinkScale
from mjfriction.diagnose.causes.payload import Payload
from mjfriction.diagnose.diagnosis import diagnose_log
from mjfriction.diagnose.fit.model import Chosen, same_columns
from mjfriction.diagnose.tell.outcome import Diagnosis, Verdict
from mjfriction.record.readers import read_log
from mjfriction.robot.files import read_robot
from tests.hidden.machine import Machine, write_case

GANTRY = """
<mujoco>
  <compiler inertiafromgeom="false"/>
  <worldbody>
    <body name="bridge">
      <joint name="x" type="slide" axis="1 0 0" range="-2 2" limited="true"/>
      <inertial pos="0 0 0" mass="120" diaginertia="9 9 9"/>
      <body name="carriage">
        <joint name="y" type="slide" axis="0 1 0" range="-2 2" limited="true"/>
        <inertial pos="0 0 0" mass="50" diaginertia="2 2 2"/>
        <body name="ram">
          <joint name="z" type="slide" axis="0 0 1" range="-2 2" limited="true"/>
          <inertial pos="0 0 0" mass="20" diaginertia="1 1 1"/>
        </body>
      </body>
    </body>
  </worldbody>
</mujoco>
"""


def heavier(model: mujoco.MjModel) -> None:
    model.body_mass[model.body("ram").id] += 8.0


def tilted(model: mujoco.MjModel) -> None:
    model.opt.gravity[:] = [0.3, 0.0, -np.sqrt(9.81**2 - 0.3**2)]


def diagnosed(folder: Path, change: Callable[[mujoco.MjModel], None]) -> Diagnosis:
    model = folder / "gantry.xml"
    model.write_text(GANTRY, encoding="utf-8")
    machine = Machine(
        model=model, joints=("x", "y", "z"), coulomb=(60.0, 30.0, 20.0), viscous=(80.0, 40.0, 30.0), change=change
    )
    log, robot = write_case(folder, machine, seed=4)
    return diagnose_log(read_log(log), read_robot(robot))


def test_a_load_and_a_heavier_ram_cannot_be_told_apart(tmp_path: Path) -> None:
    found = diagnosed(tmp_path, heavier)
    assert found.verdict is Verdict.AMBIGUOUS
    (finding,) = found.findings
    assert {finding.cause, *finding.alternatives} == {"body.payload", "body.link_inertia"}
    assert finding.confidence == pytest.approx(0.5)
    (added,) = finding.parameters
    assert added.value == pytest.approx(8.0 if finding.cause == "body.payload" else 28.0 / 20.0, rel=0.02)
    # Of a load's four numbers this motion shows one, which does what the ram's does, and not what the carriage's does.
    load, ram, carriage = (Chosen(Payload(), Site(2)), Chosen(LinkScale(), Site(2)), Chosen(LinkScale(), Site(1)))
    assert same_columns(found.gap, load, ram)
    assert not same_columns(found.gap, load, carriage)


def test_a_tilted_base_and_an_offset_cannot_be_told_apart_where_one_axis_feels_it(tmp_path: Path) -> None:
    found = diagnosed(tmp_path, tilted)
    assert found.verdict is Verdict.AMBIGUOUS
    (finding,) = found.findings
    assert {finding.cause, *finding.alternatives} == {"drive.offset", "body.gravity_direction"}
