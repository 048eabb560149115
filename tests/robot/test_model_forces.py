"""Forces of a model file beside its bodies: MuJoCo and the predicted effort agree on them, or the file is refused."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np
import pyarrow as pa
import pytest

from mjfriction.errors import RobotError
from mjfriction.record.readers.table import log_from_table
from mjfriction.robot.draft import draft_robot
from mjfriction.robot.effort import predict_effort
from mjfriction.robot.files import read_robot
from mjfriction.robot.friction_tables import FrictionTerm
from mjfriction.robot.measured_motion import measured_motion
from mjfriction.robot.robot import Robot
from mjfriction.robot.simulation import robot_spec

MASS = '<inertial pos="0.1 0 0.02" mass="2" fullinertia=".02 .03 .04 .001 .002 .003"/>'
ARM = """<mujoco>{top}<worldbody><body name="l1" pos="0 0 0.3"><joint name="j1" axis="0 .3 1" pos=".01 .02 0"/>{mass}
<body name="l2" pos="0.3 0 0" euler="10 20 30"><joint name="j2" axis="0 1 .2" {joint}/>{mass}{hand}</body></body>
</worldbody>{more}</mujoco>"""
FINGERS = "".join(
    f'<body name="f{i}"><joint name="f{i}" type="slide" ref="0.3"/>{MASS}<site name="s{i}"/></body>' for i in (1, 2)
)
# Two joints of one body: x moves y, and y the mass.
TWO = '<body name="xy" pos=".1 0 .2" euler="0 30 0"><joint name="x" type="slide" ref=".1"/>'
TWO += f'<joint name="y" axis="1 0 1" pos="0 .1 0" stiffness="3"/>{MASS}</body>'


def robot(folder: Path, listed: tuple[str, ...] = ("j1", "j2"), **parts: str) -> Robot:
    text = ARM.format(mass=MASS, **{"top": "", "joint": "", "hand": "", "more": ""} | parts)
    (folder / "arm.xml").write_text(text, encoding="utf-8")
    joints = "".join(f'[[joint]]\nname = "{name}"\n' for name in listed)
    (folder / "robot.toml").write_text(f'name = "arm"\nmodel = "arm.xml"\n{joints}', encoding="utf-8")
    return read_robot(folder / "robot.toml")


@pytest.mark.parametrize(
    "parts",
    [
        {"joint": 'stiffness="20" springref="30" ref="10"'},
        {"joint": 'stiffness="20 -3 4" springref="-25"'},
        {"joint": 'stiffness="20"', "top": '<option><flag spring="disable"/></option>'},
        {"joint": 'damping="1.5"'},
        {"joint": 'damping="1.5 2"', "top": '<option><flag damper="disable"/></option>'},
        {"top": '<option gravity="1 2 -3"><flag gravity="disable"/></option>'},
        {"hand": FINGERS, "more": '<keyframe><key name="home" qpos="0 0 0.1 0.2"/></keyframe>'},
        {"hand": FINGERS, "more": '<equality><joint joint1="f1" joint2="f2"/></equality>'},
        {"hand": FINGERS, "more": '<equality><joint joint1="j2" joint2="f2"/></equality>'},
        {"hand": TWO},
        {"more": '<tendon><fixed name="t"><joint joint="j1" coef="1"/></fixed></tendon>'},
        {"more": '<equality><connect body1="l2" anchor="0 0 0" active="false"/></equality>'},
        {
            "hand": FINGERS,
            "more": '<tendon><fixed name="grip"><joint joint="f1" coef="1"/><joint joint="f2" coef="1"/></fixed>'
            '</tendon><equality><tendon tendon1="grip"/></equality><actuator><position tendon="grip"/></actuator>',
        },
    ],
)
def test_predicted_efforts_are_those_of_mujoco(parts: dict[str, str], tmp_path: Path) -> None:
    own = robot(tmp_path, ("j1", "j2", "x", "y") if parts.get("hand") == TWO else ("j1", "j2"), **parts)
    own = own.with_stated_friction(own.body())
    time = np.arange(0.0, 3.0, 0.01)
    columns = {"time": time} | {
        f"{quantity}.{name}": size * np.sin(rate * time)
        for quantity, size in (("position", 1.0), ("effort", 5.0))
        for name, rate in zip(own.joints, (2.0, 3.0, 5.0, 7.0), strict=False)
    }
    body = own.body()
    motion = measured_motion(log_from_table(pa.table(columns), "log"), own, body, 10.0)
    model = robot_spec(own).compile()
    data, needed = mujoco.MjData(model), np.empty_like(motion.position)
    for i, state in enumerate(zip(motion.position, motion.velocity, motion.acceleration, strict=True)):
        data.qpos[:], data.qvel[:], data.qacc[:] = state
        mujoco.mj_inverse(model, data)
        needed[i] = data.qfrc_inverse
    assert np.ptp(needed) > 1.0
    moving = np.abs(motion.velocity) > 0.1  # at rest no law of friction is determined
    assert predict_effort(own, body, motion).total[moving] == pytest.approx(needed[moving], abs=1e-9)


@pytest.mark.parametrize(
    ("parts", "told"),
    [
        ({"hand": FINGERS, "more": '<equality><joint joint1="j1" joint2="j2"/></equality>'}, "the equality acts on"),
        ({"hand": '<site name="s"/>', "more": '<equality><connect body1="l2" anchor="0 0 0"/></equality>'}, "equality"),
        ({"more": '<tendon><fixed name="t" stiffness="1"><joint joint="j1" coef="1"/></fixed></tendon>'}, "tendon 't'"),
        ({"more": '<tendon><fixed name="t" range="-1 1"><joint joint="j1" coef="1"/></fixed></tendon>'}, "tendon 't'"),
        ({"hand": '<body gravcomp="1" name="tool">' + MASS + "</body>"}, "the gravcomp of body 'tool'"),
        ({"top": '<option density="1000"/>'}, "the fluid"),
        ({"joint": 'stiffness="2" springyield="1"'}, "the springyield of joint 'j2'"),
    ],
)
def test_forces_that_no_balance_of_bodies_has_are_refused(parts: dict[str, str], told: str, tmp_path: Path) -> None:
    with pytest.raises(RobotError, match=told):
        robot(tmp_path, **parts).body()


def test_damping_that_bends_is_to_be_stated_as_a_law(tmp_path: Path) -> None:
    own = robot(tmp_path, joint='damping="2 1.5"')
    with pytest.raises(RobotError, match="the model's damping of joint 'j2' is no multiple of its speed"):
        own.with_stated_friction(own.body())
    term = FrictionTerm(law="quadratic_viscous", parameters={"coulomb": 0.0, "viscous": 2.0, "quadratic": 1.5})
    stated = own.with_joint(own.joint("j2").model_copy(update={"friction": (term,)}))
    assert stated.with_stated_friction(stated.body()).joint("j2").friction == (term,)


def test_dry_friction_that_is_disabled_is_none(tmp_path: Path) -> None:
    for flag, level in (("enable", 1.5), ("disable", 0.0)):
        top = f'<option><flag frictionloss="{flag}"/></option>'
        assert robot(tmp_path, joint='frictionloss="1.5"', top=top).body().dry_friction.tolist() == [0.0, level]


def test_a_joint_of_a_urdf_that_follows_another_is_refused_where_it_is_listed(tmp_path: Path) -> None:
    link = '<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'
    links = "".join(f'<link name="l{i}">{link}</link>' for i in range(3))
    joints = "".join(
        f'<joint name="j{i}" type="continuous"><parent link="l{i - 1}"/><child link="l{i}"/>{more}</joint>'
        for i, more in ((1, ""), (2, '<mimic joint="j1"/>'))
    )
    (tmp_path / "arm.urdf").write_text(f'<robot name="arm">{links}{joints}</robot>', encoding="utf-8")
    for listed, refused in ((("j1",), False), (("j1", "j2"), True)):
        names = "".join(f'[[joint]]\nname = "{name}"\n' for name in listed)
        (tmp_path / "robot.toml").write_text(f'name = "arm"\nmodel = "arm.urdf"\n{names}', encoding="utf-8")
        own = read_robot(tmp_path / "robot.toml")
        if refused:
            with pytest.raises(RobotError, match="<mimic> acts on joint 'j2'"):
                own.body()
        else:
            assert own.body().joints == ("j1",)
    (tmp_path / "robot.toml").write_text(draft_robot(str(tmp_path / "arm.urdf"), tmp_path), encoding="utf-8")
    assert read_robot(tmp_path / "robot.toml").joints == ("j1",)


@pytest.mark.parametrize("key", ["[link_scale]\nx = 1.1", "[payload]\nmass = 1.0\ncom = [0.0, 0.0, 0.1]\nparent = 'x'"])
def test_mass_is_stated_of_the_joint_that_moves_it(key: str, tmp_path: Path) -> None:
    robot(tmp_path, ("x", "y"), hand=TWO)
    path = tmp_path / "robot.toml"
    path.write_text(f"{path.read_text(encoding='utf-8')}{key}\n", encoding="utf-8")
    with pytest.raises(RobotError, match="joint 'x' shares its body with joint 'y'; name 'y' instead"):
        read_robot(path).body()
