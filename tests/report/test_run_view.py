"""A run's recording holds the machine, its drives, its friction and its states, and stays small."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from mjfriction.control.servo import Control
from mjfriction.plant.machine import run_machine
from mjfriction.plant.motions import excitation, sine
from mjfriction.report.run_view import write_run
from mjfriction.robot.files import read_robot
from mjfriction.robot.robot import Robot
from tests.report.recordings import entities


def test_an_arms_recording(tmp_path: Path) -> None:
    robot = read_robot("comau_ns12")
    motion = excitation(robot.joints, np.zeros(6), np.full(6, 0.3), np.full(6, 0.5), 6.0)
    run = run_machine(robot, motion, 500.0, Control(bandwidth=12.0), whole=True)
    path = tmp_path / "run.rrd"
    write_run(robot, run, path)
    found = entities(path)
    for name in ("/robot/forearm", "/robot/forearm/0", "/joint_2/drive", "/joint_2/friction", "/joint_2/state/1"):
        assert name in found
    assert path.stat().st_size < 3e6


def test_a_cylinders_recording_has_its_pressures(tmp_path: Path) -> None:
    robot = read_robot("hydraulic_cylinder")
    run = run_machine(robot, sine("piston", 0.0, 0.05, 0.5, 1.0), 500.0, whole=True)
    path = tmp_path / "run.rrd"
    write_run(robot, run, path)
    assert {"/piston/pressure/head", "/piston/pressure/rod", "/piston/voltage", "/robot/piston"} <= entities(path)


def test_states_of_friction_are_kept_only_when_asked_for() -> None:
    robot = read_robot("machine_table")
    motion = sine("axis", 0.0, 1e-4, 0.5, 1.0)
    assert run_machine(robot, motion, 500.0).played.states == {}
    kept = run_machine(robot, motion, 500.0, whole=True).played.states["axis"]
    # Twelve elements' forces add up to the friction but for the damping; their modes are 0 or ±1.
    assert kept.shape[1] == 24
    assert set(np.unique(kept[:, 12:])) <= {-1.0, 0.0, 1.0}


def one_hinge(folder: Path, joint: str, link: str, shape: str = "") -> Robot:
    """Write an arm of one joint, and read it."""
    (folder / "arm.urdf").write_text(
        f'<robot name="arm"><link name="base"/><link name="{link}">{shape}<inertial><mass value="1"/><inertia ixx=".1" '
        f'iyy=".1" izz=".1" ixy="0" ixz="0" iyz="0"/></inertial></link><joint name="{joint}" type="revolute"><parent '
        f'link="base"/><child link="{link}"/><axis xyz="0 0 1"/><limit lower="-2" upper="2" effort="9" velocity="3"/>'
        "</joint></robot>"
    )
    (folder / "robot.toml").write_text(f'name = "arm"\nmodel = "arm.urdf"\n[[joint]]\nname = "{joint}"\n')
    return read_robot(folder / "robot.toml")


def test_a_joint_by_any_name_is_one_step_of_a_path(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    robot = one_hinge(tmp_path, "hinge 1/2", "arm 1")
    run = run_machine(robot, sine("hinge 1/2", 0.0, 0.5, 1.0, 3.0), 500.0, whole=True)
    write_run(robot, run, tmp_path / "run.rrd")
    assert {r"/hinge\ 1\/2/drive", r"/hinge\ 1\/2/friction"} <= entities(tmp_path / "run.rrd")
    told = capfd.readouterr()
    assert "WARN" not in told.err + told.out


@pytest.mark.parametrize(
    ("name", "content"), [("arm.dae", b"<COLLADA/>"), ("arm.stl", b"solid arm\nfacet normal 0 0 1\n")]
)
def test_a_mesh_that_cannot_be_drawn_is_not_fatal(name: str, content: bytes, tmp_path: Path) -> None:
    (tmp_path / name).write_bytes(content)
    shape = f'<visual><geometry><mesh filename="{name}"/></geometry></visual>'
    robot = one_hinge(tmp_path, "hinge", "arm", shape)
    run = run_machine(robot, sine("hinge", 0.0, 0.5, 0.5, 1.0), 250.0, whole=True)
    write_run(robot, run, tmp_path / "run.rrd")
    assert (tmp_path / "run.rrd").stat().st_size > 0
