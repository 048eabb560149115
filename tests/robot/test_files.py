"""Robot files: what is written reads back equal; what is wrong is said in one line."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from mjfriction.errors import RobotError
from mjfriction.laws.ambient import ambient
from mjfriction.robot.draft import draft_robot
from mjfriction.robot.files import read_robot, write_robot
from mjfriction.robot.friction import (
    raised_levels,
    stated_levels,
    with_asymmetric_damping,
    with_friction_wave,
    with_term,
)
from mjfriction.robot.robot import Robot, bundled_robots
from mjfriction.robot.schema import RobotTable
from mjfriction.robot.simulation import robot_laws
from mjfriction.robot.table import Wave
from tests.hidden.machine import UR5

TEXT = f"""
name = "arm"
model = "{UR5}"
[[joint]]
name = "elbow_joint"
actuator = {{ gear_ratio = 101.0, torque_constant = 0.12, rotor_inertia = 5.0e-5 }}
friction = {{ law = "coulomb_viscous", side = "joint", parameters = {{ coulomb = 10.0, viscous = 3.0 }} }}
"""


def read_text(folder: Path, text: str) -> Robot:
    path = folder / "robot.toml"
    path.write_text(text, encoding="utf-8")
    return read_robot(path)


finite = st.floats(-1e3, 1e3)
positive = st.floats(1e-3, 1e3)
laws = st.one_of(
    st.fixed_dictionaries({"coulomb": positive, "viscous": positive}).map(lambda p: ("coulomb_viscous", p)),
    st.fixed_dictionaries({"coulomb": positive, "viscous": positive, "quadratic": finite}).map(
        lambda p: ("quadratic_viscous", p)
    ),
)


@settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    names=st.lists(st.text(min_size=1, max_size=8), min_size=1, max_size=4, unique=True),
    terms=st.lists(laws, max_size=3),
    ratio=positive,
    offset=finite,
    gravity=st.none() | st.tuples(finite, finite, finite),
)
def test_what_is_written_reads_back_equal(tmp_path, names, terms, ratio, offset, gravity) -> None:  # type: ignore[no-untyped-def]
    joints = [
        {
            "name": name,
            "actuator": {"gear_ratio": ratio},
            "friction": [{"law": law, "parameters": parameters} for law, parameters in terms],
            "effort_sensor": {"offset": offset},
        }
        for name in names
    ]
    table = RobotTable.model_validate({"name": "x", "model": str(UR5), "gravity": gravity, "joint": joints})
    again = read_robot(write_robot(Robot(table, tmp_path), tmp_path, comment="two\nlines"))
    assert again.table.model_copy(update={"model": table.model}) == table
    assert again.model_path.read_text() == UR5.read_text()


def test_a_packaged_model_keeps_its_name_and_one_that_includes_others_its_place(tmp_path: Path) -> None:
    ur5 = read_robot("ur5")
    assert read_robot(write_robot(ur5, tmp_path)).table == ur5.table
    scene = tmp_path / "scene.xml"
    scene.write_text('<mujoco><include file="arm.xml"/></mujoco>')
    robot = Robot(ur5.table.model_copy(update={"model": "scene.xml"}), tmp_path)
    (tmp_path / "out").mkdir()
    assert read_robot(write_robot(robot, tmp_path / "out")).model_path == scene


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            ("gear_ratio =", "gear_ration ="),
            r"joint 'elbow_joint': actuator.gear_ration: unknown key 'gear_ration'; did you mean 'gear_ratio'.*"
            "Allowed: gear_ratio, torque_constant, rotor_inertia",
        ),
        (("friction =", "fricton ="), "unknown key 'fricton'; did you mean 'friction'"),
        (('name = "arm"', 'nam = "arm"'), "unknown key 'nam'|name: Field required"),
        (("gear_ratio = 101.0", "gear_ratio = 0.0"), "a gear ratio of 0 moves nothing"),
        (("coulomb = 10.0", 'coulomb = "10"'), r"friction\.parameters\.coulomb: .*number.*given: '10'"),
        (("[[joint]]", "gravity = [0.0, 0.0]\n[[joint]]"), "'gravity' has 2 values, which are too few"),
        (("gear_ratio = 101.0", 'gear_ratio = "big"'), r"gear_ratio: .*number.*given: 'big'"),
        (("torque_constant = 0.12", "torque_constant = -1.0"), "torque_constant: .*greater than 0.*given: -1.0"),
        (("coulomb = 10.0", "coulomb = -10.0"), "parameter 'coulomb' = -10 N·m: allowed is at least 0"),
        (
            ("coulomb = 10.0", "colomb = 10.0"),
            "law 'coulomb_viscous' has no parameter 'colomb'; did you mean 'coulomb'",
        ),
        (
            ("coulomb_viscous", "coulomb_viscos"),
            "unknown friction law 'coulomb_viscos'; did you mean 'coulomb_viscous'",
        ),
        (('side = "joint"', 'side = "load"'), "friction.side: .*'joint' or 'motor'"),
        (("[[joint]]", "[[joint"), "not valid TOML"),
    ],
)
def test_a_wrong_key_is_named(tmp_path: Path, change: tuple[str, str], message: str) -> None:
    with pytest.raises(RobotError, match=message) as caught:
        read_text(tmp_path, TEXT.replace(*change))
    assert str(tmp_path) in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_joint_listed_twice_and_a_file_that_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(RobotError, match="joint 'elbow_joint' is listed twice"):
        read_text(tmp_path, TEXT + '[[joint]]\nname = "elbow_joint"\n')
    with pytest.raises(RobotError, match="no such robot file"):
        read_robot(tmp_path / "absent.toml")
    with pytest.raises(RobotError, match="no such robot file; bundled robots are .*ur5"):
        read_robot(tmp_path / "empty.toml")
    (tmp_path / "result").mkdir()
    with pytest.raises(RobotError, match=r"result/robot.toml: there is no such"):
        read_robot(tmp_path / "result")
    written = write_robot(read_robot("ur5"), tmp_path / "result")
    assert read_robot(tmp_path / "result") == read_robot(written)
    with pytest.raises(RobotError, match="neither a file nor a bundled robot; did you mean 'ur5'"):
        read_robot("ur55")
    (tmp_path / "arm.urdf").write_text("<robot/>")
    with pytest.raises(RobotError, match=r"this is a model file; .*mjfriction new .*arm.urdf --out .*arm.toml"):
        read_robot(tmp_path / "arm.urdf")
    with pytest.raises(RobotError, match="one package that can be named"):
        _ = read_text(tmp_path, TEXT.replace(str(UR5), "package://elsewhere/a.urdf")).model_path


def test_bundled_robots_read() -> None:
    assert {"ur5", "linear_axis"} <= set(bundled_robots())
    for name in bundled_robots():
        assert read_robot(name).body().joints == read_robot(name).joints


def test_a_joint_without_a_law_takes_what_the_model_file_states() -> None:
    robot = read_robot("linear_axis")
    stated = robot.with_stated_friction(robot.body())
    assert stated_levels(stated.joint("axis")) == (25.0, 180.0)


def test_levels_move_at_the_joint_whatever_side_the_law_is_on(tmp_path: Path) -> None:
    robot = read_text(tmp_path, TEXT.replace('side = "joint"', 'side = "motor"'))
    before = stated_levels(robot.joint("elbow_joint"))
    assert before == pytest.approx((1010.0, 3.0 * 101.0**2))
    after = stated_levels(raised_levels(robot, "elbow_joint", -100.0, 50.0).joint("elbow_joint"))
    assert after == pytest.approx((910.0, 3.0 * 101.0**2 + 50.0))


def test_asymmetry_keeps_the_mean_and_splits_the_directions(tmp_path: Path) -> None:
    robot = with_asymmetric_damping(read_text(tmp_path, TEXT), "elbow_joint", -1.0)
    (term,) = robot.joint("elbow_joint").friction or ()
    assert term.law == "asymmetric"
    assert term.parameters == {
        "coulomb_positive": 10.0,
        "coulomb_negative": 10.0,
        "viscous_positive": 2.0,
        "viscous_negative": 4.0,
    }
    assert stated_levels(robot.joint("elbow_joint")) == (10.0, 3.0)
    twice = with_asymmetric_damping(robot, "elbow_joint", -0.5)
    assert (twice.joint("elbow_joint").friction or ())[0].parameters["viscous_negative"] == 4.5
    more = with_term(robot, "elbow_joint", "quadratic_viscous", {"coulomb": 0.0, "viscous": 0.0, "quadratic": 1.0})
    assert [t.law for t in more.joint("elbow_joint").friction or ()] == ["asymmetric", "quadratic_viscous"]


@pytest.mark.parametrize("ratio", [50.0, -50.0])
@pytest.mark.parametrize("side", ["joint", "motor"])
def test_taking_over_the_damping_changes_no_torque_by_itself(ratio: float, side: str, tmp_path: Path) -> None:
    values = "coulomb_positive = 1.0, coulomb_negative = 2.0, viscous_positive = 0.3, viscous_negative = 0.1"
    text = TEXT.replace("101.0", str(ratio)).replace('side = "joint"', f'side = "{side}"')
    robot = read_text(
        tmp_path, text.replace("coulomb_viscous", "asymmetric").replace("coulomb = 10.0, viscous = 3.0", values)
    )
    velocity = np.array([-1.0, -0.2, 0.2, 1.0])

    def torque(of: Robot) -> np.ndarray:
        (term,) = of.joint("elbow_joint").friction or ()
        return term.friction(ratio).steady(velocity, ambient(4))

    taken = with_asymmetric_damping(robot, "elbow_joint", 0.0)
    np.testing.assert_allclose(torque(taken), torque(robot), rtol=1e-9)
    more = with_asymmetric_damping(robot, "elbow_joint", 0.05)
    np.testing.assert_allclose(torque(more) - torque(robot), 0.05 * np.abs(velocity), atol=1e-9)


def test_waves_keep_a_level_to_ride_on_and_no_torque_changes_by_it(tmp_path: Path) -> None:
    values = "coulomb_positive = 1.0, coulomb_negative = 2.0, viscous_positive = 0.3, viscous_negative = 0.1"
    text = TEXT.replace("coulomb_viscous", "asymmetric").replace("coulomb = 10.0, viscous = 3.0", values)
    plain = read_text(tmp_path, text)
    waved = with_friction_wave(plain, "elbow_joint", Wave(wavenumber=20.0, cosine=0.3, sine=0.1))
    velocity = np.array([-1.0, -0.2, 0.2, 1.0])

    def torque(of: Robot) -> np.ndarray:
        own = of.joint("elbow_joint").friction or ()
        return np.sum([term.friction(101.0).steady(velocity, ambient(4)) for term in own], axis=0)

    before, after = (with_asymmetric_damping(robot, "elbow_joint", 0.05) for robot in (plain, waved))
    np.testing.assert_allclose(torque(after), torque(before), rtol=1e-9)
    assert stated_levels(after.joint("elbow_joint")) == pytest.approx(stated_levels(before.joint("elbow_joint")))
    robot_laws(after)


def test_levels_that_fall_need_no_law_of_their_own() -> None:
    robot = read_robot("comau_ns12")
    before = robot.joint("joint_2")
    after = raised_levels(robot, "joint_2", -0.04, -0.21).joint("joint_2")
    assert len(after.friction or ()) == len(before.friction or ())
    assert stated_levels(after)[1] == pytest.approx(stated_levels(before)[1] - 0.21)


@pytest.mark.parametrize("name", ["comau_ns12", "ur5"])
def test_a_wave_of_friction_is_carried_by_a_law_whatever_the_joint_has(name: str) -> None:
    robot = read_robot(name)
    joint = robot.joints[1]
    for _ in range(2):
        robot = with_friction_wave(robot, joint, Wave(wavenumber=20.0, cosine=0.3, sine=0.1))
    laws = [law.law.name for law in robot_laws(robot)[joint]]
    assert laws.count("position_dependent") == 1
    assert len(robot.joint(joint).friction_waves) == 2


def test_an_installed_model_is_named_by_its_package() -> None:
    text = draft_robot(str(read_robot("z1").model_path), Path("anywhere"))
    assert 'model = "package://example-robot-data/z1_description/' in text


def test_a_joint_that_the_model_lacks_is_said_of_the_robot(tmp_path: Path) -> None:
    model = read_robot("z1").table.model
    (tmp_path / "robot.toml").write_text(f'name = "mine"\nmodel = "{model}"\n[[joint]]\nname = "joint_3"\n')
    with pytest.raises(RobotError, match=r"robot 'mine': .*joint_3"):
        read_robot(tmp_path / "robot.toml").body()


@pytest.mark.parametrize("name", ["robot.urdf", "robot.xml"])
def test_a_model_file_that_was_written_anew_is_read_anew(name: str, tmp_path: Path) -> None:
    weighing = {
        "robot.urdf": (
            '<robot name="a"><link name="base"/><link name="arm"><inertial><mass value="{mass}"/>'
            '<inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>'
            '<joint name="j" type="continuous"><parent link="base"/><child link="arm"/><axis xyz="0 1 0"/></joint>'
            "</robot>"
        ),
        "robot.xml": (
            '<mujoco><worldbody><body name="arm"><joint name="j" axis="0 1 0"/>'
            '<inertial pos="0 0 0" mass="{mass}" diaginertia="1 1 1"/></body></worldbody></mujoco>'
        ),
    }[name]
    (tmp_path / "robot.toml").write_text(f'name = "a"\nmodel = "{name}"\n[[joint]]\nname = "j"\n', encoding="utf-8")
    found = []
    for i, mass in enumerate((1.0, 2.0)):
        model = tmp_path / name
        model.write_text(weighing.format(mass=mass), encoding="utf-8")
        os.utime(model, ns=(i, i))
        found.append(read_robot(str(tmp_path / "robot.toml")).body().model.inertias[1].mass)
    assert found == [1.0, 2.0]


def test_a_model_in_which_nothing_that_moves_has_a_mass_is_refused(tmp_path: Path) -> None:
    """As CAD exports leave them: every effort would be a payload's, a spring's, or whatever fits."""
    joint = '<parent link="base"/><child link="arm"/><axis xyz="0 0 1"/>'
    joint += '<limit lower="-1" upper="1" effort="1" velocity="1"/>'
    urdf = '<robot name="bare"><link name="base"/><link name="arm">{}</link>'
    urdf += f'<joint name="turn" type="revolute">{joint}</joint></robot>'
    (tmp_path / "robot.toml").write_text('name = "bare"\nmodel = "bare.urdf"\n[[joint]]\nname = "turn"\n')
    inertial = '<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'
    (tmp_path / "bare.urdf").write_text(urdf.format(inertial))
    assert read_robot(tmp_path).body().model.inertias[1].mass == 1.0
    (tmp_path / "bare.urdf").write_text(urdf.format("") + "<!-- saved anew -->")
    with pytest.raises(RobotError, match="no link that moves has a mass"):
        read_robot(tmp_path).body()
