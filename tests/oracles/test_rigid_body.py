"""Pinocchio, as the package uses it, against MuJoCo."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np
import pytest

from mjfriction.body.inertia import RigidLink
from mjfriction.body.inverse import inertia_at, inverse_dynamics
from mjfriction.body.model import Load, load_body
from mjfriction.body.regressor import gravity_torques, link_torques, tip_link, tip_mass, tip_mass_torques
from mjfriction.errors import RobotError
from mjfriction.identify.protocol import room
from mjfriction.robot.files import read_robot
from mjfriction.robot.plain_model import in_plain_words
from mjfriction.robot.robot import bundled_robots
from mjfriction.sim.spec import compiled, read_spec
from tests.hidden.machine import UR5, UR5_JOINTS, mujoco_model, rigid_torque

MIXED = """
<mujoco><option gravity="0 1 -9"/><compiler angle="radian"/><worldbody>
  <body name="l1" pos="0 0 .1" euler="0.1 0.2 0">
    <joint name="turn" axis="0 0 1" armature="0.3" damping="0.5" frictionloss="0.7" ref="0.2"/>
    <inertial pos="0.1 0 0" mass="2" fullinertia="0.1 0.12 0.14 0.01 0.02 0.015"/>
    <body name="l2" pos="0.3 0 .1" quat="0.9 0.1 0.3 0.1">
      <joint name="slide" type="slide" axis="1 0.3 0" armature="0.1" pos="0.1 0 0"/>
      <geom type="box" size="0.1 0.1 0.2" pos="0.1 0 0.1" mass="1.5"/>
      <body name="l3" pos="0.3 0 .1">
        <joint name="tip" axis="1 0.3 0" pos="0.1 0 0.2"/><geom type="capsule" size="0.05 0.2" density="800"/>
      </body></body></body></worldbody></mujoco>"""


def states(joints: int, count: int = 50) -> tuple[np.ndarray, ...]:
    rng = np.random.default_rng(4)
    return tuple(rng.normal(size=(count, joints)) for _ in range(3))


def assert_agrees(path: Path, joints: tuple[str, ...], armature: np.ndarray | None = None) -> None:
    model = mujoco_model(path)
    if armature is not None:
        model.dof_armature[:] += armature
    order = [model.joint(name).dofadr[0] for name in joints]
    q, v, a = states(len(joints))
    body = load_body(path, joints, rotor_inertia=armature, text=in_plain_words(path))
    mine = inverse_dynamics(body, q, v, a)
    full = np.zeros((3, q.shape[0], model.nv))
    for k, values in enumerate((q, v, a)):
        full[k][:, order] = values
    model.dof_damping[:] = 0.0
    theirs = rigid_torque(model, *full)[:, order]
    np.testing.assert_allclose(mine, theirs, rtol=1e-9, atol=1e-9 * np.abs(theirs).max())
    still = np.zeros_like(q)
    gravity = rigid_torque(model, full[0], 0.0 * full[1], 0.0 * full[2])[:, order]
    np.testing.assert_allclose(
        inverse_dynamics(body, q, still, still), gravity, atol=1e-9 * max(np.abs(gravity).max(), 1.0)
    )
    data = mujoco.MjData(model)
    data.qpos[:] = full[0][0]
    mujoco.mj_forward(model, data)
    mass = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, mass)
    np.testing.assert_allclose(inertia_at(body, q[0]), np.diag(mass)[order], rtol=1e-9)


def test_urdf_arm_agrees() -> None:
    assert_agrees(UR5, UR5_JOINTS)
    assert_agrees(UR5, UR5_JOINTS, armature=np.array([0.5, 0.4, 0.3, 0.2, 0.1, 0.05]))


def test_joints_may_come_in_any_order() -> None:
    order = [3, 0, 5, 1, 4, 2]
    q, v, a = states(6)
    straight = inverse_dynamics(load_body(UR5, UR5_JOINTS), q, v, a)
    body = load_body(UR5, [UR5_JOINTS[i] for i in order])
    np.testing.assert_allclose(
        inverse_dynamics(body, q[:, order], v[:, order], a[:, order]), straight[:, order], rtol=1e-12
    )


MESSY = """<mujoco><compiler angle="degree" autolimits="true" eulerseq="xyz"/>
  <default><default class="arm"><joint axis="0 0 1" damping="0.3"/><geom type="capsule" size="0.05" density="2700"/>
    <default class="thin"><geom size="0.02"/></default><default class="rail"><joint type="slide"/></default>
  </default></default>
  <asset><mesh name="cover" file="gone.stl"/><texture name="sky" type="2d" file="gone.png"/>
    <material name="paint" texture="sky"/></asset>
  <worldbody><geom type="plane" size="2 2 .1"/><geom type="mesh" mesh="cover"/>
    <body name="base" childclass="arm"><geom type="cylinder" size=".1 .05" mass="7"/>
    <frame pos="0 0 0.1" euler="0 15 0">
      <body name="carriage"><joint name="rail" class="rail" axis="1 0 0" range="-0.4 0.5"/>
      <geom type="box" size=".1 .08 .03" material="paint"/>
      <body pos="0 0 0.2" euler="20 -10 5"><joint name="shoulder" axis="0 1 0" range="-90 120" pos="0 0 0.02"/>
        <geom fromto="0 0 0 0.1 0 0.4" mass="9"/><geom type="sphere" size=".04" pos="0.1 0 .4" mass="1.5"/>
        <body name="fore" pos="0.1 0 0.4"><joint name="elbow" axis="0 1 0" frictionloss="0.7" armature="0.02"/>
          <inertial pos="0 0.01 0.2" mass="3" fullinertia="0.03 0.031 0.004 0.001 0 0.002"/>
          <geom type="mesh" mesh="cover"/><geom class="thin" fromto="0 0 0 0 0 0.3"/>
          <body name="flange" pos="0 0 0.35" euler="0 0 40"><geom class="thin" type="sphere" mass="0.8"/>
            <site name="tip"/></body></body></body></body></frame></body></worldbody>
  <actuator><motor joint="elbow"/></actuator><sensor><framepos objtype="site" objname="tip"/></sensor></mujoco>"""


def test_mjcf_in_the_words_of_those_who_know_mujoco_agrees(tmp_path: Path) -> None:
    """Classes, shapes that weigh, frames, degrees, a body without a name; a mesh and a picture that are not there."""
    path, joints = tmp_path / "messy.xml", ("rail", "shoulder", "elbow")
    path.write_text(MESSY)
    body = load_body(path, joints, text=in_plain_words(path))
    assert body.sliding == (True, False, False)
    np.testing.assert_allclose(body.damping, 0.3)
    np.testing.assert_allclose(body.dry_friction, [0.0, 0.0, 0.7])
    whole = tmp_path / "whole.xml"
    there = MESSY.replace('<mesh name="cover" file="gone.stl"/>', "").replace('<geom type="mesh" mesh="cover"/>', "")
    there = there.replace('<texture name="sky" type="2d" file="gone.png"/>', "").replace(' texture="sky"', "")
    whole.write_text(there)
    assert_agrees(whole, joints)
    q, v, a = states(3)
    same = inverse_dynamics(load_body(whole, joints, text=in_plain_words(whole)), q, v, a)
    np.testing.assert_allclose(inverse_dynamics(body, q, v, a), same, rtol=1e-12)
    with pytest.raises(RobotError, match="an MJCF is read in plain words"):
        load_body(whole, joints)


def test_a_joint_that_is_held_may_have_the_name_of_its_link(tmp_path: Path) -> None:
    path = tmp_path / "gripper.xml"
    path.write_text(MESSY.replace('<body name="fore"', '<body name="elbow"'))
    held = load_body(path, ("rail", "shoulder"), text=in_plain_words(path), payload=Load(1.0, (0.0, 0.0, 0.1), "elbow"))
    whole = load_body(path, ("rail", "shoulder", "elbow"), text=in_plain_words(path))
    q, v, a = states(3)
    still = [np.column_stack([course[:, :2], np.zeros(len(course))]) for course in (q, v, a)]
    loaded = whole.holding(Load(1.0, (0.0, 0.0, 0.1), "elbow"))
    theirs = inverse_dynamics(loaded, *still)[:, :2]
    np.testing.assert_allclose(inverse_dynamics(held, *(course[:, :2] for course in still)), theirs, rtol=1e-9)


def test_mjcf_with_slides_own_gravity_and_armature_agrees(tmp_path: Path) -> None:
    path = tmp_path / "mixed.xml"
    path.write_text(MIXED)
    assert_agrees(path, ("turn", "slide", "tip"))
    body = load_body(path, ("turn", "slide", "tip"), text=in_plain_words(path))
    assert body.sliding == (False, True, False)
    assert body.damping[0] == 0.5
    assert body.dry_friction[0] == 0.7


@pytest.mark.parametrize("name", sorted(bundled_robots()))
def test_every_bundled_robot_agrees(name: str) -> None:
    robot = read_robot(name)
    assert_agrees(robot.model_path, robot.joints)


def test_links_sum_to_the_whole() -> None:
    q, v, a = states(6)
    body = load_body(UR5, UR5_JOINTS)
    np.testing.assert_allclose(
        link_torques(body, q, v, a).sum(axis=2), inverse_dynamics(body, q, v, a), rtol=1e-9, atol=1e-9
    )


def test_payload_is_a_mass_at_the_flange() -> None:
    # Held still with the arm stretched out along x, 2 kg at the flange weighs on the shoulder with its lever arm.
    still = np.zeros((1, 6))
    bare = load_body(UR5, UR5_JOINTS)
    loaded = load_body(UR5, UR5_JOINTS, payload=Load(2.0, (0.0, 0.0, 0.0), "wrist_3_link"))
    model = mujoco_model(UR5)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    lever = data.body("wrist_3_link").xpos - data.joint("shoulder_lift_joint").xanchor
    torque = (inverse_dynamics(loaded, still, still, still) - inverse_dynamics(bare, still, still, still))[0, 1]
    axis = data.joint("shoulder_lift_joint").xaxis
    assert torque == pytest.approx(-np.dot(np.cross(lever, [0.0, 0.0, -2.0 * 9.81]), axis), rel=1e-9)


def test_scaling_a_link_scales_its_share() -> None:
    q, v, a = states(6, 5)
    body = load_body(UR5, UR5_JOINTS)
    scaled = load_body(UR5, UR5_JOINTS, link_scale={"elbow_joint": 1.3})
    share = link_torques(body, q, v, a)[:, :, body.links.index("elbow_joint")]
    difference = inverse_dynamics(scaled, q, v, a) - inverse_dynamics(body, q, v, a)
    np.testing.assert_allclose(difference, 0.3 * share, atol=1e-9)


@pytest.mark.parametrize("angle", ["", '<compiler angle="radian"/>'])
def test_the_ranges_of_hinges_and_slides_are_mujocos(angle: str, tmp_path: Path) -> None:
    text = f"""<mujoco>{angle}<worldbody><body name="a"><joint name="slide" type="slide" range="-0.1 0.4"/>
    <geom size=".1"/><body name="b"><joint name="hinge" range="-1.5 0.5"/><geom size=".1"/></body></body>
    </worldbody></mujoco>"""
    (tmp_path / "arm.xml").write_text(text)
    body = load_body(tmp_path / "arm.xml", ("slide", "hinge"), text=in_plain_words(tmp_path / "arm.xml"))
    ranges = mujoco.MjModel.from_xml_string(text).jnt_range
    np.testing.assert_allclose(np.column_stack([body.lower, body.upper]), ranges, rtol=1e-12)


def one_joint(folder: Path, kind: str, limit: str) -> Path:
    path = folder / "arm.urdf"
    path.write_text(f"""<robot name="arm"><link name="base"/><link name="bar"><inertial><mass value="1"/>
    <inertia ixx=".01" iyy=".01" izz=".01" ixy="0" ixz="0" iyz="0"/></inertial></link>
    <joint name="joint" type="{kind}"><parent link="base"/><child link="bar"/><axis xyz="0 1 0"/>
    <limit effort="9" velocity="3" {limit}/></joint></robot>""")
    return path


@pytest.mark.parametrize("limit", ["", 'lower="0" upper="0"'])
@pytest.mark.parametrize("kind", ["revolute", "prismatic"])
def test_a_urdf_that_states_no_range_has_none(
    kind: str, limit: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    path = one_joint(tmp_path, kind, limit)
    body = load_body(path, ("joint",))
    assert (body.lower[0], body.upper[0]) == (-np.inf, np.inf)
    model = compiled(read_spec(path, ("joint",)))
    assert not model.jnt_limited[0]
    assert capfd.readouterr().err == ""
    if kind == "revolute":
        middle, reach = room(body)
        assert (middle[0], reach[0]) == (0.0, pytest.approx(1.2))
    else:
        with pytest.raises(RobotError, match="joint 'joint' slides, and its model file states no range"):
            room(body)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("<mujoco/>", "an MJCF is read in plain words"),
        ("<robot name='x'><link></robot>", "not well-formed XML: mismatched tag: line 1"),
        ("<robot name='x'></robot>", "cannot be read as URDF"),
        ("<sdf/>", "root element is <sdf>"),
    ],
)
def test_a_model_that_does_not_parse_is_one_line(
    tmp_path: Path, text: str, message: str, capfd: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "bad.urdf"
    path.write_text(text)
    with pytest.raises(RobotError, match=message) as caught:
        load_body(path, ["a"])
    assert "\n" not in str(caught.value)
    assert capfd.readouterr().err == ""


def test_unknown_names_suggest_the_nearest() -> None:
    with pytest.raises(RobotError, match="did you mean 'elbow_joint'"):
        load_body(UR5, ["elbow_jont"])
    with pytest.raises(RobotError, match="payload parent 'wrist_3_lin' is no link.*wrist_3_link"):
        load_body(UR5, UR5_JOINTS, payload=Load(1.0, (0, 0, 0), "wrist_3_lin"))
    ball = RigidLink(1.0, (0.0, 0.0, 0.0), (1.0, 1.0, 1.0, 0.0, 0.0, 0.0))
    with pytest.raises(RobotError, match="link_inertia: there is no joint 'elbow'.*elbow_joint"):
        load_body(UR5, UR5_JOINTS, link_inertia={"elbow": ball})
    with pytest.raises(RobotError, match="no such model file"):
        load_body(Path("nowhere.urdf"), ["a"])


@pytest.mark.parametrize("name", sorted(bundled_robots()))
def test_tip_mass_and_gravity_enter_as_the_model_itself_says(name: str) -> None:
    robot = read_robot(name)
    body = robot.body()
    q, v, a = states(len(body.joints), 5)
    stated = load_body(robot.model_path, robot.joints, text=in_plain_words(robot.model_path))
    own = tip_mass(body)[1]
    errors = []
    for far in (0.0, 0.04, 0.02):
        centre = own + far * np.array([0.3, -0.5, 0.8])
        load = Load(2.0, (centre[0], centre[1], centre[2]), tip_link(body))
        loaded = load_body(robot.model_path, robot.joints, text=in_plain_words(robot.model_path), payload=load)
        needed = inverse_dynamics(loaded, q, v, a) - inverse_dynamics(stated, q, v, a)
        share = tip_mass_torques(body, q, v, a) @ np.array([2.0, *(2.0 * centre)])
        errors.append(float(np.max(np.abs(needed - share))))
        there = tip_mass_torques(body, q, v, a, about=centre) @ np.array([2.0, *(2.0 * centre)])
        np.testing.assert_allclose(there, needed, atol=1e-9)
    # Exact at the link's own centre; beside it, of second order: the mass's moment of inertia.
    assert errors[0] < 1e-9
    assert errors[2] == pytest.approx(errors[1] / 4.0, rel=1e-6, abs=1e-9)
    gravity = (0.3, -0.4, -9.0)
    turned = load_body(robot.model_path, robot.joints, text=in_plain_words(robot.model_path), gravity=gravity)
    difference = inverse_dynamics(turned, q, v, a) - inverse_dynamics(stated, q, v, a)
    change = (np.array(gravity) - stated.gravity)[None, :]
    np.testing.assert_allclose(gravity_torques(body, q, change)[:, :, 0], difference, atol=1e-9)
