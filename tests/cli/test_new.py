"""A robot file drawn up from a model file alone."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet
import pytest

from mjfriction.robot.files import read_robot
from mjfriction.robot.robot import resolve_model
from tests.cli.here import mjfriction_here

Z1 = "package://example-robot-data/z1_description/urdf/z1.urdf"
ARM = """<mujoco><worldbody><body name="column"><joint name="lift" type="slide" axis="0 0 1" range="-0.1 0.4"
frictionloss="3"/><geom size=".1"/><body name="ball"><joint name="wrist" type="ball"/><geom size=".1"/>
<body name="flange"><joint name="tool" axis="1 0 0"/><geom size=".1"/></body></body></body></worldbody></mujoco>"""


def test_a_draft_reads_back_as_the_robot_that_its_model_is(tmp_path: Path) -> None:
    done = mjfriction_here("new", Z1, "--out", tmp_path / "z1.toml")
    assert done.returncode == 0, done.stderr
    robot = read_robot(tmp_path / "z1.toml")
    assert robot.joints[:6] == tuple(f"joint{k}" for k in range(1, 7))
    assert robot.model_path == resolve_model(Z1, Path())
    stated = read_robot(tmp_path / "z1.toml").with_stated_friction(robot.body())
    # With the comment marks of friction taken away the file says the same as before.
    text = (tmp_path / "z1.toml").read_text()
    (tmp_path / "said.toml").write_text(re.sub(r"^# friction", "friction", text, flags=re.MULTILINE))
    assert read_robot(tmp_path / "said.toml").table.joint == stated.table.joint
    assert "# actuator = { gear_ratio" in text


def test_a_grippers_joints_are_left_out_unless_there_are_no_others(tmp_path: Path) -> None:
    panda = "package://example-robot-data/panda_description/urdf/panda.urdf"
    assert mjfriction_here("new", panda, "--out", tmp_path / "panda.toml").returncode == 0
    assert read_robot(tmp_path / "panda.toml").joints == tuple(f"panda_joint{k}" for k in range(1, 8))
    hand = ARM.replace('"lift"', '"left_finger"').replace('"tool"', '"gripper_turn"')
    (tmp_path / "hand.xml").write_text(hand)
    assert mjfriction_here("new", tmp_path / "hand.xml", "--out", tmp_path / "hand.toml").returncode == 0
    assert read_robot(tmp_path / "hand.toml").joints == ("left_finger", "gripper_turn")


def test_slides_and_hinges_are_listed_and_balls_are_not(tmp_path: Path) -> None:
    (tmp_path / "models").mkdir()
    (tmp_path / "models/arm.xml").write_text(ARM)
    assert mjfriction_here("new", tmp_path / "models/arm.xml", "--out", tmp_path / "arm.toml").returncode == 0
    robot = read_robot(tmp_path / "arm.toml")
    assert robot.joints == ("lift", "tool")
    assert robot.table.model == "models/arm.xml"
    text = (tmp_path / "arm.toml").read_text()
    assert "slides from -0.1 to 0.4 m" in text
    assert "coulomb = 3, viscous = 0" in text


def test_a_log_says_which_joints_and_in_which_order(tmp_path: Path) -> None:
    time = np.arange(200) / 100.0
    columns = {"time": time, "position.joint3": np.sin(time), "position.joint1": np.cos(time)}
    pa.parquet.write_table(pa.table(columns), tmp_path / "log.parquet")
    done = mjfriction_here("new", Z1, "--log", tmp_path / "log.parquet", "--out", tmp_path / "z1.toml")
    assert done.returncode == 0, done.stderr
    assert read_robot(tmp_path / "z1.toml").joints == ("joint3", "joint1")


@pytest.mark.parametrize(
    ("model", "said"),
    [
        ("nowhere.urdf", "there is no such model file"),
        ("package://other/arm.urdf", "the one package that can be named"),
        ("balls.xml", "no hinge and no slide"),
    ],
)
def test_what_cannot_be_drawn_up_is_said_in_a_line(model: str, said: str, tmp_path: Path) -> None:
    (tmp_path / "balls.xml").write_text(re.sub(r'<joint name="(lift|tool)"[^/]*/>', "", ARM))
    named = model if "://" in model else tmp_path / model
    done = mjfriction_here("new", named, "--out", tmp_path / "robot.toml")
    assert done.returncode == 2
    assert said in done.stderr
    assert len(done.stderr.strip().splitlines()) == 1
    assert not (tmp_path / "robot.toml").exists()


def test_a_file_that_is_there_is_kept(tmp_path: Path) -> None:
    (tmp_path / "z1.toml").write_text("what I know")
    assert mjfriction_here("new", Z1, "--out", tmp_path / "z1.toml").returncode == 2
    assert (tmp_path / "z1.toml").read_text() == "what I know"
