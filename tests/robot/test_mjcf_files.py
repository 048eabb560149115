"""MJCF files as people have them: mounted anyhow, with grippers, servos, keyframes and meshes that are not there."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np
import pyarrow as pa
import pytest

from mjfriction.body.inverse import inverse_dynamics
from mjfriction.errors import RobotError, SimulationError
from mjfriction.identify.measure import measure_gap
from mjfriction.identify.stretches import cut_stretches, missed
from mjfriction.plant.machine import simulate
from mjfriction.plant.motions import excitation
from mjfriction.plant.sensors import Recorder
from mjfriction.record.log import Log
from mjfriction.record.readers.table import log_from_table
from mjfriction.robot.draft import draft_robot
from mjfriction.robot.files import read_robot
from mjfriction.robot.robot import Robot
from mjfriction.robot.simulation import robot_spec

MASS = '<inertial pos="0.1 0.05 0.2" mass="2" diaginertia=".03 .02 .01"/>'
BASE = f'pos="0 0 1" euler="30 50 0">{MASS}'
JOINT = 'range="-170 170"'


def arm(base: str = BASE, joint: str = JOINT, hand: str = "", more: str = "", link: str = MASS) -> str:
    """Return an arm of two joints on a base."""
    return (
        f'<mujoco><worldbody><body name="base" {base}<body name="l1"><joint name="j1" axis="0 0 1" {JOINT}/>{link}'
        f'<body name="l2" pos="0 0 0.4"><joint name="j2" axis="0 1 0" {joint}/>{MASS}{hand}</body></body></body>'
        f"</worldbody>{more}</mujoco>"
    )


def written(folder: Path, text: str, joints: tuple[str, ...] = ("j1", "j2")) -> Robot:
    listed = ", ".join(
        f'{{ name = "{joint}", friction = {{ law = "coulomb_viscous", parameters = {{ coulomb = 0.4, viscous = 0.3 }} '
        "} }"
        for joint in joints
    )
    (folder / "arm.xml").write_text(text, encoding="utf-8")
    (folder / "robot.toml").write_text(f'name = "arm"\nmodel = "arm.xml"\njoint = [ {listed} ]\n', encoding="utf-8")
    return read_robot(folder / "robot.toml")


def recorded(robot: Robot, seconds: float = 6.0) -> Log:
    count = len(robot.joints)
    motion = excitation(robot.joints, np.zeros(count), np.full(count, 0.8), np.full(count, 2.0), seconds, seed=2)
    return log_from_table(pa.table(simulate(robot, motion, recorder=Recorder(500.0))), "log")


def worst(robot: Robot) -> float:
    """Return how far Pinocchio's efforts are from MuJoCo's, N·m or N."""
    model = robot_spec(robot).compile()
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
    data, states = mujoco.MjData(model), np.random.default_rng(0).normal(size=(3, 20, len(robot.joints)))
    columns = [int(model.joint(name).dofadr[0]) for name in robot.joints]
    needed = np.empty(states.shape[1:])
    for row, (q, v, a) in enumerate(states.swapaxes(0, 1)):
        data.qpos[columns], data.qvel[columns], data.qacc[columns] = q, v, a
        mujoco.mj_inverse(model, data)
        needed[row] = data.qfrc_inverse[columns]
    return float(np.max(np.abs(needed - inverse_dynamics(robot.body(), *states))))


@pytest.mark.parametrize("base", [BASE, f'quat="0 1 0 1">{MASS}', f'euler="0 90 0"><joint name="j0"/>{MASS}'])
def test_gravity_pulls_at_an_arm_as_its_base_is_mounted(base: str, tmp_path: Path) -> None:
    assert worst(written(tmp_path, arm(base))) < 1e-9
    hung = written(tmp_path, arm(base)).body()
    upright = written(tmp_path, arm(f">{MASS}")).body()
    rest = np.zeros((1, 2))
    efforts = [inverse_dynamics(body, rest, rest, rest) for body in (hung, upright)]
    assert np.max(np.abs(efforts[0] - efforts[1])) > 1.0


SHAPE = '<geom type="mesh" mesh="m"/>'
LOST = '<asset><mesh name="m" file="not_there.stl"/></asset>'


def test_shapes_whose_meshes_are_missing_are_left_out(tmp_path: Path) -> None:
    whole = written(tmp_path, arm())
    efforts = recorded(whole).columns["effort.j2"]
    # The base states no mass, and moves nothing; shapes with no density are only seen.
    seen = '<geom type="mesh" mesh="m" density="0"/>'
    robot = written(tmp_path, arm(f'pos="0 0 1" euler="30 50 0">{SHAPE}', link=MASS + SHAPE + seen, more=LOST))
    assert worst(robot) < 1e-9
    np.testing.assert_allclose(recorded(robot).columns["effort.j2"], efforts, atol=1e-9)


@pytest.mark.parametrize(
    "asset",
    [
        '<texture name="t" type="2d" file="lost.png"/>',
        '<texture name="t" type="cube" fileright="lost.png" fileleft="lost.png"/>',
        '<texture name="t" builtin="flat" type="2d" width="2" height="2"/><hfield name="h" file="lost.png" '
        'size="1 1 1 1"/>',
    ],
)
def test_pictures_that_are_missing_are_left_out(asset: str, tmp_path: Path) -> None:
    painted = f'<asset>{asset}<material name="m" texture="t"/></asset>'
    ball = '<geom size=".01" material="m" contype="0" conaffinity="0"/>'
    assert worst(written(tmp_path, arm(hand=ball, more=painted))) < 1e-9


CORNERS = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], dtype=np.float32)
FACES = ((0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3))


def test_meshes_that_only_mujoco_finds_are_there(tmp_path: Path) -> None:
    # That of a model that is attached lies beside that model; the folders of a file name may be stripped.
    (tmp_path / "hand").mkdir()
    sides = b"".join(
        np.r_[np.zeros((1, 3)), 0.1 * CORNERS[list(face)]].astype("<f4").tobytes() + b"\0\0" for face in FACES
    )
    (tmp_path / "hand" / "m.stl").write_bytes(b"\0" * 80 + len(FACES).to_bytes(4, "little") + sides)
    mesh, shape = '<asset><mesh name="m" file="{}"/></asset>', '<geom type="mesh" mesh="m"/>'
    hand = f'<mujoco>{mesh.format("m.stl")}<worldbody><body name="hand">{shape}</body></worldbody></mujoco>'
    (tmp_path / "hand" / "hand.xml").write_text(hand, encoding="utf-8")
    attached = arm(
        hand='<attach model="hand" body="hand" prefix="g_"/>',
        more='<asset><model name="hand" file="hand/hand.xml"/></asset>',
    )
    stripped = arm(
        hand=f"<body>{shape}</body>", more=f'<compiler strippath="true" meshdir="hand"/>{mesh.format("far/m.stl")}'
    )
    for text in (attached, stripped):
        robot = written(tmp_path, text)
        assert robot_spec(robot).compile().ngeom == 1
        assert worst(robot) < 1e-9


def test_a_body_that_needs_a_missing_mesh_for_its_mass_is_named(tmp_path: Path) -> None:
    robot = written(tmp_path, arm(link=SHAPE, more=LOST))
    for needs in (robot.body, lambda: robot_spec(robot)):
        with pytest.raises((RobotError, SimulationError), match=r"body 'l1' states no inertia.*not_there\.stl"):
            needs()


SERVOS = (
    '<actuator><position joint="j1" kp="200" kv="20"/><position joint="j2" kp="200" kv="20"/></actuator>'
    '<keyframe><key name="home" qpos="0.1 0.2" ctrl="0.1 0.2"/></keyframe>'
)


def test_a_models_own_servos_do_not_fight_the_efforts_of_a_log(tmp_path: Path) -> None:
    log = recorded(written(tmp_path, arm()))
    off = []
    for more in ("", SERVOS):
        robot = written(tmp_path, arm(more=more))
        gap = measure_gap(log, robot)
        off.append(missed(gap, [robot], cut_stretches(gap, robot, 0.25)))
    np.testing.assert_array_equal(*off)
    assert np.max(np.abs(off[0])) < 0.02


def test_a_keyframe_with_controls_is_no_hindrance(tmp_path: Path) -> None:
    plain, servos = (recorded(written(tmp_path, arm(more=more)), 1.0) for more in ("", SERVOS))
    np.testing.assert_array_equal(servos.columns["effort.j1"], plain.columns["effort.j1"])


GRIPPER = (
    f'<body name="left" pos="0 .02 .3"><joint name="left" axis="1 0 0"/>{MASS}</body>'
    f'<body name="right" pos="0 -.02 .3"><joint name="right" axis="1 0 0"/>{MASS}</body><site name="s" pos="0 0 .4"/>'
)
CLOSED = '<equality><connect body1="left" body2="right" anchor="0 0 .1"/></equality>'


def test_a_loop_within_a_gripper_does_not_act_on_the_arm(tmp_path: Path) -> None:
    text = arm(hand=GRIPPER, more=CLOSED)
    assert worst(written(tmp_path, text)) < 1e-9
    with pytest.raises(RobotError, match="the equality acts on joints 'left', 'right', and predictions"):
        written(tmp_path, text, ("j1", "left", "right")).body()
    to_the_world = CLOSED.replace('body2="right" ', "")
    with pytest.raises(RobotError, match="the equality acts on joints 'j1', 'j2'"):
        written(tmp_path, arm(hand=GRIPPER, more=to_the_world)).body()


@pytest.mark.parametrize(
    ("equality", "listed"),
    [(CLOSED, ("j1", "j2")), ('<equality><joint joint1="right" joint2="left"/></equality>', ("j1", "j2", "left"))],
)
def test_a_draft_leaves_out_what_an_equality_couples(equality: str, listed: tuple[str, ...], tmp_path: Path) -> None:
    written(tmp_path, arm(hand=GRIPPER, more=equality))
    draft = draft_robot(str(tmp_path / "arm.xml"), tmp_path)
    (tmp_path / "draft.toml").write_text(draft, encoding="utf-8")
    assert read_robot(tmp_path / "draft.toml").body().joints == listed


def test_the_range_of_a_joint_with_a_reference_is_mujocos(tmp_path: Path) -> None:
    body = written(tmp_path, arm(joint='range="0 180" ref="90"')).body()
    assert (body.lower[1], body.upper[1]) == pytest.approx((0.0, np.pi))


def test_joints_without_a_name_have_one_everywhere(tmp_path: Path) -> None:
    text = arm().replace('name="j1"', "").replace('name="j2"', "")
    robot = written(tmp_path, text, ("joint 0", "joint 1"))
    assert worst(robot) < 1e-9


def test_a_run_against_a_stop_says_so(tmp_path: Path) -> None:
    robot = written(tmp_path, arm(joint='range="-20 20"'))
    with pytest.warns(UserWarning, match="joint 'j2' is at a stop of its range for"):
        recorded(robot, 2.0)


def test_a_run_in_which_something_is_touched_says_so(tmp_path: Path) -> None:
    ball, wall = '<geom size=".05" pos="0 0 .3"/>', '<geom type="plane" size="1 1 1" pos="0 0 1.2" zaxis="0 0 -1"/>'
    text = arm(hand=ball).replace("<worldbody>", f"<worldbody>{wall}")
    with pytest.warns(UserWarning, match="shapes of the model touch each other for"):
        recorded(written(tmp_path, text), 1.0)
