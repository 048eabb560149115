"""Friction laws as a robot file holds them: lists, wrappers, and edits that every law takes."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mjfriction.errors import LawError, RobotError
from mjfriction.laws.ambient import ambient
from mjfriction.laws.catalog import LAWS
from mjfriction.laws.friction import Level, Wave, friction
from mjfriction.robot.files import read_robot, write_robot
from mjfriction.robot.friction import raised_levels, stated_levels
from mjfriction.robot.friction_tables import FrictionTerm
from mjfriction.robot.schema import Joint
from tests.contract.draws import named

URDF = """<robot name="one"><link name="base"/><link name="arm"><inertial><mass value="1"/>
<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="hinge" type="continuous"><parent link="base"/><child link="arm"/><axis xyz="0 0 1"/></joint></robot>"""
LUGRE = {
    "coulomb": 6.0,
    "static": 9.0,
    "stribeck_velocity": 0.05,
    "stribeck_exponent": 2.0,
    "bristle_stiffness": 4e3,
    "bristle_damping": 12.0,
    "viscous": 1.5,
}
EASIER = {"coulomb": 3.0, "static": 4.0, "viscous": 0.5}


def write(folder: Path, friction_line: str):
    (folder / "one.urdf").write_text(URDF)
    (folder / "robot.toml").write_text(
        f'name = "one"\nmodel = "one.urdf"\n[[joint]]\nname = "hinge"\n{friction_line}\n'
    )
    return folder / "robot.toml"


def test_lists_and_wrappers_go_through_a_file_and_back(tmp_path: Path) -> None:
    path = write(
        tmp_path,
        'friction = [{ law = "maxwell_slip", '
        "parameters = { viscous = 0.1, stiffness = [3e3, 1e3], level = [1.0, 2.0] }, "
        "level = { per_load = 0.01, waves = [{ wavenumber = 2.0, cosine = 0.1 }] } },\n"
        '  { law = "coulomb_viscous", side = "motor", parameters = { coulomb = 1.0, viscous = 0.1 }, '
        "negative = { coulomb = 0.5 } }]",
    )
    robot = read_robot(path)
    (tmp_path / "again").mkdir()
    write_robot(robot, tmp_path / "again")
    assert read_robot(tmp_path / "again" / "robot.toml").table == robot.table
    first, second = robot.table.joint[0].friction or ()
    assert first.friction(1.0).state_count == 2
    assert second.value("coulomb") == 0.75


def test_wrong_values_are_one_line_with_the_file_and_the_joint(tmp_path: Path) -> None:
    cases = [
        ('friction = { law = "lugre", parameters = { coulomb = 1.0 } }', "needs 'static'"),
        ('friction = { law = "lugrr", parameters = { coulomb = 1.0 } }', "did you mean 'lugre'"),
        (
            'friction = { law = "asymmetric", parameters = { coulomb_positive = 1.0, coulomb_negative = 1.0, '
            "viscous_positive = 0.0, viscous_negative = 0.0 }, negative = { coulomb_positive = 2.0 } }",
            "already has both directions",
        ),
        (
            'friction = { law = "maxwell_slip", '
            "parameters = { viscous = 0.0, stiffness = [1.0], level = [1.0, 2.0] } }",
            "'stiffness' has 1 values and 'level' 2",
        ),
    ]
    for line, message in cases:
        with pytest.raises(RobotError, match=message) as caught:
            read_robot(write(tmp_path, line))
        assert "robot.toml" in str(caught.value)
        assert "\n" not in str(caught.value)


def test_a_value_out_of_bounds_says_joint_law_parameter_unit_and_value(tmp_path: Path) -> None:
    line = 'friction = { law = "coulomb_viscous", parameters = { coulomb = -2.5, viscous = 0.1 } }'
    with pytest.raises(RobotError) as caught:
        read_robot(write(tmp_path, line))
    for word in ("hinge", "coulomb_viscous", "coulomb", "N·m", "-2.5"):
        assert word in str(caught.value)


def test_a_gear_ratio_of_nothing_is_refused() -> None:
    with pytest.raises(LawError, match="gear_ratio = 0"):
        friction("coulomb", {"coulomb": 1.0}, gear_ratio=0.0)


@given(v=st.floats(-3.0, 3.0), ratio=st.floats(0.5, 200.0), backward=st.booleans())
def test_through_a_gear_speed_and_torque_are_multiplied(v: float, ratio: float, backward: bool) -> None:
    r = -ratio if backward else ratio
    law = LAWS["load_dependent"]
    p = law.pack({"coulomb": 2.0, "load": 0.1, "viscous": 0.3})
    joint = friction("load_dependent", {"coulomb": 2.0, "load": 0.1, "viscous": 0.3}, gear_ratio=r)
    expected = r * law.steady(r * v, ambient(1, load=30.0 / r)[0], p)
    assert joint.steady(np.array([v]), ambient(1, load=30.0))[0] == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("r", [1.0, -50.0])
def test_a_law_counts_its_rotor_as_load_where_it_is_told_to(r: float) -> None:
    values = {"coulomb": 2.0, "load": 0.1, "viscous": 0.3}
    around, rows = ambient(1, load=30.0, rotor=-12.0), np.array([0.7])
    plain = friction("load_dependent", values, gear_ratio=r)
    whole = friction("load_dependent", values, gear_ratio=r, load_includes_rotor=True)
    assert plain.steady(rows, around) == plain.steady(rows, ambient(1, load=30.0))
    assert whole.steady(rows, around) == pytest.approx(plain.steady(rows, ambient(1, load=18.0)), rel=1e-12)
    assert whole.follow(rows, around, 1e-3)[0] == pytest.approx(plain.follow(rows, ambient(1, load=18.0), 1e-3)[0])


def test_the_level_of_any_law_scales_and_its_damping_stays() -> None:
    level = Level(per_load=0.02, per_kelvin=-0.01, reference_temperature=20.0, waves=(Wave(3.0, 0.1, 0.05),))
    factor = 1.0 + 0.02 * 12.0 - 0.01 * 10.0 + 0.1 * math.cos(1.5) + 0.05 * math.sin(1.5)
    around = ambient(400, load=-12.0, position=0.5, temperature=30.0)
    v = 0.1 * np.sin(np.linspace(0.0, 9.0, 400))
    for name in ("stribeck", "lugre", "gms", "dahl"):
        values = named(LAWS[name], 1)
        plain = friction(name, {**values, "viscous": 0.0}).follow(v, around, 1e-3)[0]
        scaled = friction(name, {**values, "viscous": 2.0}, level=level).follow(v, around, 1e-3)[0]
        np.testing.assert_allclose(scaled, factor * plain + 2.0 * v, rtol=1e-9, atol=1e-9)


def test_two_directions_of_a_static_law_are_the_asymmetric_law() -> None:
    v = np.linspace(-2.0, 2.0, 41)
    two = friction("coulomb_viscous", {"coulomb": 2.0, "viscous": 0.3}, negative={"coulomb": 5.0, "viscous": 0.1})
    values = {"coulomb_positive": 2.0, "coulomb_negative": 5.0, "viscous_positive": 0.3, "viscous_negative": 0.1}
    one = friction("asymmetric", values)
    np.testing.assert_allclose(two.steady(v, ambient(41)), one.steady(v, ambient(41)), rtol=1e-12)
    np.testing.assert_allclose(two.follow(v, ambient(41), 1e-3)[0], one.follow(v, ambient(41), 1e-3)[0], rtol=1e-12)


def test_two_directions_of_a_bristle_law_each_reach_their_curve_without_a_jump() -> None:
    two = friction("lugre", LUGRE, negative=EASIER)
    around = ambient(40_000)
    v = 0.1 * np.sin(np.linspace(0.0, 4.0 * np.pi, 40_000))
    torque = two.follow(v, around, 1e-4)[0]
    forward = friction("lugre", LUGRE).steady(np.array([0.1]), around[:1])[0]
    backward = friction("lugre", {**LUGRE, **EASIER}).steady(np.array([-0.1]), around[:1])[0]
    assert torque[np.argmax(v)] == pytest.approx(forward, rel=1e-3)
    assert torque[np.argmin(v)] == pytest.approx(backward, rel=1e-3)
    assert np.max(np.abs(np.diff(torque))) < 0.05
    assert np.sum(torque[20_000:] * v[20_000:]) > 0.0


@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS.keys())
@given(seed=st.integers(0, 50), coulomb=st.floats(-0.5, 3.0), viscous=st.floats(-0.2, 2.0))
def test_raised_levels_raise_what_is_stated_by_as_much(law, seed: int, coulomb: float, viscous: float) -> None:
    """Whatever the law: the levels a robot states after an edit are those before plus the edit, never below zero."""
    values = {name: tuple(v) if isinstance(v, list) else v for name, v in named(law, seed).items()}
    joint = Joint(name="hinge", friction=(FrictionTerm(law=law.name, parameters=values),))

    class Holder:
        def joint(self, name: str) -> Joint:
            return joint

        def with_joint(self, changed: Joint) -> Joint:
            return changed

    before = stated_levels(joint)
    changed = raised_levels(Holder(), "hinge", coulomb, viscous)  # type: ignore[arg-type]
    after = stated_levels(changed)  # type: ignore[arg-type]
    for kind, wanted in enumerate((coulomb, viscous)):
        if wanted >= 0.0:
            assert after[kind] == pytest.approx(before[kind] + wanted, abs=1e-9)
        else:  # what would make a level negative is not taken
            assert max(before[kind] + wanted, 0.0) - 1e-9 <= after[kind] <= before[kind] + 1e-9
    for term in changed.friction or ():  # type: ignore[attr-defined]
        FrictionTerm.model_validate(term.model_dump())


def test_the_travel_of_springs_is_their_level_over_their_stiffness() -> None:
    for stribeck_velocity in (0.05, 5e-4):
        law = {**LUGRE, "stribeck_velocity": stribeck_velocity}
        for ratio in (1.0, 50.0, -100.0):
            expected = 9.0 / 4e3 / abs(ratio)
            assert friction("lugre", law, gear_ratio=ratio).travel == pytest.approx(expected, rel=1e-3)
    elements = {"stiffness": [3e3, 1e3], "level": [1.0, 2.0], "viscous": 0.1}
    assert friction("maxwell_slip", elements).travel == pytest.approx(3.0 / 4e3, rel=1e-3)
    assert friction("coulomb_viscous", {"coulomb": 1.0, "viscous": 0.1}).travel == 0.0


@pytest.mark.parametrize("law", [name for name, own in LAWS.items() if own.states + own.states_per_element])
def test_every_law_with_springs_yields_somewhere(law: str) -> None:
    assert 0.0 < friction(law, named(LAWS[law], 0)).travel < 1.0
