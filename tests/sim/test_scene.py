"""Pictures of robots: bodies stand where Pinocchio says, shapes come from the files, bones where there are none."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

from mjfriction.robot.files import read_robot
from mjfriction.robot.robot import Robot, bundled_robots
from mjfriction.robot.simulation import robot_spec
from mjfriction.sim.scene import Scene, draw
from mjfriction.sim.spec import read_spec
from tests.hidden.machine import UR5

BARE = """
<robot name="bare"><link name="base"/><link name="arm"><inertial><mass value="1"/><origin xyz="0.2 0 0"/>
<inertia ixx=".01" iyy=".01" izz=".01" ixy="0" ixz="0" iyz="0"/></inertial></link><link name="hand"><inertial>
<mass value="1"/><inertia ixx=".01" iyy=".01" izz=".01" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="a" type="revolute"><parent link="base"/><child link="arm"/><origin xyz="0 0 .1"/><axis xyz="0 0 1"/>
<limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
<joint name="b" type="revolute"><parent link="arm"/><child link="hand"/><origin xyz=".4 0 0"/><axis xyz="0 1 0"/>
<limit lower="-1" upper="1" effort="1" velocity="1"/></joint></robot>"""


def scene(robot: Robot, course: np.ndarray) -> Scene:
    return draw(robot_spec(robot), robot.model_path, robot.joints, course)


@pytest.mark.parametrize("name", sorted(bundled_robots()))
def test_every_bundled_robot_shows_itself(name: str) -> None:
    robot = read_robot(name)
    seen = scene(robot, np.zeros((2, len(robot.joints))))
    moving = set(seen.bodies[1:])
    assert {shape.body for shape in seen.shapes} & moving
    assert all(shape.colour[3] > 0.0 for shape in seen.shapes)


def test_bodies_stand_where_pinocchio_says() -> None:
    robot = read_robot("ur5")
    course = np.random.default_rng(2).normal(size=(5, 6))
    seen = scene(robot, course)
    model = pin.buildModelFromUrdf(str(UR5))
    data = model.createData()
    for row, place, turn in zip(course, seen.position, seen.quaternion, strict=True):
        pin.framesForwardKinematics(model, data, row)
        for body in ("upper_arm_link", "forearm_link", "wrist_3_link", "tool0"):
            there = data.oMf[model.getFrameId(body, pin.FrameType.BODY)]
            i = seen.bodies.index(body)
            np.testing.assert_allclose(place[i], there.translation, atol=1e-9)
            w, x, y, z = turn[i]
            np.testing.assert_allclose(pin.Quaternion(w, x, y, z).matrix(), there.rotation, atol=1e-9)


def test_a_urdfs_meshes_are_as_large_as_its_links() -> None:
    seen = scene(read_robot("ur5"), np.zeros((1, 6)))
    arm = next(shape for shape in seen.shapes if shape.body == "upper_arm_link")
    assert arm.kind == "mesh"
    assert arm.vertices is not None
    assert arm.faces is not None
    assert np.max(arm.faces) < len(arm.vertices)
    assert 0.4 < np.max(np.ptp(arm.vertices, axis=0)) < 0.7  # 0.425 m from shoulder to elbow


def test_a_robot_without_shapes_is_drawn_as_bones(tmp_path: Path) -> None:
    path = tmp_path / "bare.urdf"
    path.write_text(BARE)
    seen = draw(read_spec(path, ("a", "b")), path, ("a", "b"), np.zeros((1, 2)))
    assert {shape.kind for shape in seen.shapes} == {"capsule", "sphere"}
    bone = next(shape for shape in seen.shapes if shape.body == "arm")
    assert bone.size[1] == pytest.approx(0.2)  # half of the way from joint to joint


def test_shapes_weigh_nothing(tmp_path: Path) -> None:
    # A link without an inertial would take its mass from its shapes.
    shaped = '<link name="base"><visual><geometry><box size=".2 .2 .1"/></geometry></visual></link>'
    cover = '<link name="cover"><visual><geometry><sphere radius=".1"/></geometry></visual></link>'
    fixed = '<joint name="f" type="fixed"><parent link="hand"/><child link="cover"/></joint></robot>'
    path = tmp_path / "shaped.urdf"
    path.write_text(BARE.replace('<link name="base"/>', shaped + cover).replace("</robot>", fixed))
    spec = read_spec(path, ("a", "b"))
    seen = draw(spec, path, ("a", "b"), np.zeros((1, 2)))
    assert {shape.kind for shape in seen.shapes} == {"box", "sphere"}
    model = spec.compile()
    assert model.body("cover").mass[0] == 0.0
    assert model.body_mass.sum() == pytest.approx(2.0)
