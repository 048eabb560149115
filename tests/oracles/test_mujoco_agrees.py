"""The same robot file feeds MuJoCo and Pinocchio: both give one torque, for every robot that ships."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np
import pytest
from numpy.polynomial.polynomial import polyval

from mjfriction.body.inverse import inverse_dynamics
from mjfriction.errors import RobotError, SimulationError
from mjfriction.laws.ambient import ambient
from mjfriction.robot.body_tables import LinkInertia, Payload
from mjfriction.robot.files import read_robot
from mjfriction.robot.friction_tables import FrictionTerm
from mjfriction.robot.robot import Robot, bundled_robots
from mjfriction.robot.schema import Spring
from mjfriction.robot.simulation import robot_laws, robot_spec
from mjfriction.robot.table import Wave
from mjfriction.sim.springs import add_springs


def changed(robot: Robot, **tables: object) -> Robot:
    return Robot(robot.table.model_copy(update=tables), robot.folder)


def compare(robot: Robot) -> float:
    body, model = robot.body(), robot_spec(robot).compile()
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
    model.dof_damping[:] = 0.0
    data = mujoco.MjData(model)
    rng = np.random.default_rng(0)
    q, v, a = rng.normal(size=(3, 40, len(robot.joints)))
    columns = [int(model.joint(name).dofadr[0]) for name in robot.joints]
    worst = 0.0
    for row, expected in zip(range(40), inverse_dynamics(body, q, v, a), strict=True):
        data.qpos[columns], data.qvel[columns], data.qacc[columns] = q[row], v[row], a[row]
        mujoco.mj_inverse(model, data)
        worst = max(worst, float(np.max(np.abs(data.qfrc_inverse[columns] - expected))))
    return worst


@pytest.mark.parametrize("name", bundled_robots())
def test_every_robot_that_ships(name: str) -> None:
    assert compare(read_robot(name)) < 1e-9


def test_payload_links_and_gravity_are_built_in_alike() -> None:
    robot = changed(
        read_robot("ur5"),
        payload=Payload(mass=1.2, com=(0.0, 0.02, 0.05), parent="wrist_3_link"),
        link_scale={"elbow_joint": 1.1, "wrist_3_joint": 1.3},
        gravity=(0.3, 0.1, -9.7),
    )
    assert compare(robot) < 1e-9
    assert compare(changed(robot, joint=robot.table.joint[:4], link_scale={})) < 1e-9  # the last two held at zero


@pytest.mark.parametrize("count", [6, 5])  # the last joint moves, or is held
def test_a_payload_is_on_a_link_or_on_what_a_joint_moves(count: int) -> None:
    bare = read_robot("ur5")
    some = changed(bare, joint=bare.table.joint[:count])
    held = [
        changed(some, payload=Payload(mass=1.2, com=(0.01, 0.02, 0.05), parent=parent))
        for parent in ("wrist_3_link", "wrist_3_joint")
    ]
    assert all(compare(robot) < 1e-9 for robot in held)
    state = np.linspace(-1.0, 1.0, count)[None]
    by_link, by_joint, none = (inverse_dynamics(r.body(), state, 0 * state, 0 * state) for r in (*held, some))
    np.testing.assert_array_equal(by_link, by_joint)
    assert np.max(np.abs(by_link - none)) > 1.0


HEAVY = LinkInertia(mass=3.1, com=(0.02, -0.01, 0.3), inertia=(0.12, 0.11, 0.02, 0.003, -0.002, 0.001))
# A link of two bodies, its joint away from the body's origin, its axes turned.
JOINTED = """<mujoco><compiler angle="radian"/><worldbody><body name="a" pos="0 0 1" euler="0.2 0.1 0">
  <joint name="turn" axis="0 1 0" pos="0.1 0.2 0.3"/><inertial pos="0.5 0 0" mass="2" diaginertia=".1 .2 .25"/>
  <body name="f" pos="0.3 0 0" euler="0 0.5 0"><geom size="0.1" mass="1"/></body>
  <body name="b" pos="1 0 0" euler="0.3 0 0"><joint name="tip" axis="0 0 1"/>
  <inertial pos=".2 0 0" mass="1" diaginertia=".01 .01 .01"/></body></body></worldbody></mujoco>"""


def test_a_links_own_inertia_takes_the_place_of_the_models(tmp_path: Path) -> None:
    robot = changed(read_robot("ur5"), link_inertia={"elbow_joint": HEAVY})
    assert compare(robot) < 1e-9
    q = np.random.default_rng(1).normal(size=(20, 6))
    stated, own = (inverse_dynamics(one.body(), q, q, q) for one in (read_robot("ur5"), robot))
    assert np.max(np.abs(own - stated)) > 1.0
    loaded = {
        "payload": Payload(mass=1.2, com=(0.0, 0.02, 0.05), parent="wrist_3_link"),
        "link_scale": {"elbow_joint": 1.1},
    }
    assert compare(changed(robot, link_shift={"elbow_joint": (0.0, 0.01, 0.0)}, **loaded)) < 1e-9
    (tmp_path / "arm.xml").write_text(JOINTED)
    (tmp_path / "robot.toml").write_text(
        'name = "a"\nmodel = "arm.xml"\njoint = [ { name = "turn" }, { name = "tip" } ]\n'
    )
    of_two_bodies = read_robot(tmp_path / "robot.toml")
    assert compare(changed(of_two_bodies, link_inertia={"turn": HEAVY})) < 1e-9
    assert compare(changed(of_two_bodies, link_shift={"turn": (0.01, -0.02, 0.03)})) < 1e-9


# A table, a cube that lies on it, and two arms beside it, each on the world.
SCENE = """<mujoco><worldbody><body name="table" pos="0 0 -0.1"><geom type="box" size="1 1 .05"/></body>
  <body name="cube" pos="0.3 0 0.1"><freejoint/><geom type="box" size=".02 .02 .02"/></body>
  <body name="left" pos="0 1 0" euler="20 0 0"><joint name="left" axis="1 0 0"/>
  <inertial pos="0 0.1 0.2" mass="5" diaginertia=".1 .1 .1"/>
  <body name="upper" pos="0 0 .4"><joint name="upper" axis="0 1 0"/>
  <inertial pos="0.1 0 0.2" mass="2" diaginertia=".1 .1 .1"/></body></body>
  <body name="right" pos="1 0 0" euler="0 90 0"><joint name="right" axis="0 1 0"/>
  <inertial pos="0.2 0 0.1" mass="3" diaginertia=".1 .1 .1"/></body></worldbody></mujoco>"""


@pytest.mark.parametrize("joints", [("left", "upper", "right"), ("right",), ("left", "upper")])
def test_arms_may_stand_beside_others_and_beside_a_table(joints: tuple[str, ...], tmp_path: Path) -> None:
    (tmp_path / "scene.xml").write_text(SCENE)
    named = ", ".join(f'{{ name = "{joint}" }}' for joint in joints)
    (tmp_path / "robot.toml").write_text(f'name = "scene"\nmodel = "scene.xml"\njoint = [ {named} ]\n')
    assert compare(read_robot(tmp_path / "robot.toml")) < 1e-9


def test_a_spring_is_the_stated_torque() -> None:
    robot = read_robot("ur5")
    joint = robot.joint("elbow_joint").model_copy(update={"spring": Spring(stiffness=8.0, preload=4.0)})
    model = robot_spec(robot.with_joint(joint)).compile()
    data = mujoco.MjData(model)
    data.qpos[2] = 0.7
    mujoco.mj_forward(model, data)
    assert data.qfrc_spring[2] == pytest.approx(-(8.0 * 0.7 + 4.0))


@pytest.mark.parametrize("limits", ["", 'range="-170 170"', 'range="0.1 0.4" type="slide"'])
@pytest.mark.parametrize("coefficients", [(4.0, 0.0, 0.0, 0.0), (4.0, 0.5, 0.8, 0.0), (-0.2, 0.0, -3.0, 1e-5)])
def test_a_spring_that_pushes_one_way_everywhere_is_that_torque_too(
    coefficients: tuple[float, ...], limits: str
) -> None:
    spec = mujoco.MjSpec.from_string(
        f'<mujoco><worldbody><body><joint name="j" {limits}/><geom size=".1"/></body></worldbody></mujoco>'
    )
    add_springs(spec, {"j": coefficients})
    spec.compile()
    model = mujoco.MjModel.from_xml_string(spec.to_xml())  # with the digits that a file has
    data = mujoco.MjData(model)
    along = np.linspace(*(model.jnt_range[0] if limits else (-2.0 * np.pi, 2.0 * np.pi)), 9)
    torque = polyval(along, coefficients)
    # The pull of the far tendon changes by 1e-5, and the six digits of a file are another 1e-5 of it.
    for q, expected in zip(along, torque, strict=True):
        data.qpos[0] = q
        mujoco.mj_forward(model, data)
        assert data.qfrc_spring[0] == pytest.approx(-expected, abs=2e-5 * np.max(np.abs(torque)))


def test_springs_add_to_the_models_own_in_either_unit() -> None:
    for angle, unit in (("degree", 180.0 / np.pi), ("radian", 1.0)):
        text = (
            f'<mujoco><compiler angle="{angle}"/><worldbody><body>'
            f'<joint name="j" stiffness="5" springref="{0.2 * unit}"/><geom size=".1"/></body></worldbody></mujoco>'
        )
        spec = mujoco.MjSpec.from_string(text)
        add_springs(spec, {"j": (1.0, 2.0, -0.8, 0.5)})
        model = spec.compile()
        data = mujoco.MjData(model)
        for q in (0.7, -1.3):
            data.qpos[0] = q
            mujoco.mj_forward(model, data)
            bent = -0.8 * q**2 + 0.5 * q**3
            assert data.qfrc_spring[0] == pytest.approx(-(5.0 * (q - 0.2) + 1.0 + 2.0 * q + bent))


def test_a_spring_that_takes_the_models_own_away_leaves_none() -> None:
    spec = mujoco.MjSpec.from_string(
        '<mujoco><worldbody><body><joint name="j" stiffness="5"/><geom size=".1"/></body></worldbody></mujoco>'
    )
    add_springs(spec, {"j": (0.0, -5.0, 0.0, 0.0)})
    model = spec.compile()
    assert model.ntendon == 0
    np.testing.assert_array_equal(model.jnt_stiffness, 0.0)


def test_friction_waves_go_onto_the_level() -> None:
    robot = read_robot("ur5")
    wavy = robot.joint("elbow_joint").model_copy(update={"friction_waves": (Wave(wavenumber=8.0, sine=0.7),)})
    (law,) = robot_laws(robot.with_joint(wavy))["elbow_joint"]
    around = ambient(1, position=0.2)
    stated = wavy.friction[0]  # type: ignore[index]
    expected = stated.value("coulomb") + 0.7 * np.sin(1.6) + stated.value("viscous")
    assert law.steady(np.array([1.0]), around)[0] == pytest.approx(expected)
    term = FrictionTerm(law="coulomb", parameters={"coulomb": 1.0})
    with pytest.raises(RobotError, match="friction_waves, friction_spots and friction_edges vary the level of a plain"):
        robot_laws(robot.with_joint(wavy.model_copy(update={"friction": (term,)})))


def test_a_body_that_is_not_there_is_named() -> None:
    robot = changed(read_robot("ur5"), payload=Payload(mass=1.0, parent="hand"))
    with pytest.raises(SimulationError, match="no body or joint 'hand'"):
        robot_spec(robot)
    robot = changed(read_robot("ur5"), payload=Payload(mass=1.0, parent="wrist_3"))
    with pytest.raises(SimulationError, match=r"no body or joint 'wrist_3' .*did you mean 'wrist_3_(link|joint)'"):
        robot_spec(robot)
