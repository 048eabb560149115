"""A planar arm, whose motion cannot show where along its axes a payload lies: it is found all the same."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pyarrow as pa
import pytest

from mjfriction.diagnose.diagnosis import diagnose_log
from mjfriction.diagnose.tell.outcome import Verdict
from mjfriction.plant.machine import simulate
from mjfriction.plant.motions import excitation
from mjfriction.plant.sensors import Recorder
from mjfriction.record.readers.table import log_from_table
from mjfriction.robot.body_tables import Payload
from mjfriction.robot.files import read_robot
from mjfriction.robot.robot import Robot

LINK = """<link name="{name}"><inertial><mass value="{mass}"/><origin xyz="0 0 {centre}"/>
<inertia ixx="{inertia}" iyy="{inertia}" izz="0.001" ixy="0" ixz="0" iyz="0"/></inertial></link>"""
JOINT = """<joint name="{name}" type="revolute"><parent link="{parent}"/><child link="{child}"/><origin xyz="0 0 {z}"/>
<axis xyz="0 1 0"/><limit lower="-3" upper="3" effort="50" velocity="4"/></joint>"""
URDF = (
    '<robot name="planar"><link name="base"/>'
    + LINK.format(name="upper", mass=2.0, centre=-0.2, inertia=0.02)
    + LINK.format(name="fore", mass=1.2, centre=-0.2, inertia=0.01)
    + LINK.format(name="hand", mass=0.4, centre=-0.03, inertia=0.001)
    + JOINT.format(name="shoulder", parent="base", child="upper", z=0.0)
    + JOINT.format(name="elbow", parent="upper", child="fore", z=-0.4)
    + JOINT.format(name="wrist", parent="fore", child="hand", z=-0.35)
    + "</robot>"
)
HIDDEN = Payload(mass=0.3, com=(0.02, 0.05, -0.06), parent="hand")


def planar(folder: Path) -> Robot:
    (folder / "planar.urdf").write_text(URDF)
    joints = "".join(
        f'[[joint]]\nname = "{name}"\nposition_sensor = {{ resolution = 2e-5 }}\neffort_sensor = {{ noise = 0.02 }}\n'
        'friction = { law = "coulomb_viscous", parameters = { coulomb = 0.2, viscous = 0.1 } }\n'
        for name in ("shoulder", "elbow", "wrist")
    )
    (folder / "robot.toml").write_text(f'name = "planar"\nmodel = "planar.urdf"\n{joints}')
    return read_robot(folder / "robot.toml")


@pytest.mark.deep
def test_the_payload_is_weighed_without_what_the_motion_cannot_show(tmp_path: Path) -> None:
    stated = planar(tmp_path)
    machine = Robot(stated.table.model_copy(update={"payload": HIDDEN}), stated.folder)
    motion = excitation(stated.joints, np.zeros(3), np.full(3, 1.2), np.full(3, 2.0), 40.0, seed=3)
    columns = simulate(machine, motion, recorder=Recorder(250.0), controller_robot=stated, seed=1)
    found = diagnose_log(log_from_table(pa.table(columns), "planar"), stated)
    (finding,) = found.findings
    assert finding.cause == "body.payload"
    fitted = {parameter.name: parameter for parameter in finding.parameters}
    assert "moment_y" not in fitted  # along the axes, where neither gravity nor motion feels it
    assert fitted["mass"].value == pytest.approx(0.3, rel=0.1)
    assert fitted["moment_x"].value == pytest.approx(0.3 * 0.02, abs=0.003)
    assert fitted["moment_z"].value == pytest.approx(-0.3 * 0.06, abs=0.003)
    assert found.robot.table.payload is not None


def test_without_gravity_no_tilt_is_asked_for(tmp_path: Path) -> None:
    """An arm that works lying down, in a model whose gravity is switched off, has no direction to be off."""
    stated = planar(tmp_path)
    stated = Robot(stated.table.model_copy(update={"gravity": (0.0, 0.0, 0.0)}), stated.folder)
    motion = excitation(stated.joints, np.zeros(3), np.full(3, 1.2), np.full(3, 2.0), 15.0, seed=3)
    columns = simulate(stated, motion, recorder=Recorder(250.0), seed=1)
    found = diagnose_log(log_from_table(pa.table(columns), "planar"), stated)
    assert (found.findings, found.verdict) == ((), Verdict.CONSISTENT)
