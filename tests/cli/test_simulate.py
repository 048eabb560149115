"""``mjfriction simulate``: a log of the contract out, the same for the same seed, one line for bad input."""

from __future__ import annotations

from pathlib import Path

import pyarrow.parquet
import pytest

from mjfriction.plant.motions import sine
from mjfriction.record.readers import read_log
from tests.cli.here import mjfriction_here


@pytest.fixture
def swing(tmp_path: Path) -> Path:
    path = tmp_path / "swing.parquet"
    pyarrow.parquet.write_table(sine("elbow_joint", 0.5, 0.6, 0.3, 3.0).table(), path)
    return path


def test_a_log_comes_out_that_the_diagnosis_reads(swing: Path, tmp_path: Path) -> None:
    logs = []
    for name in ("one.parquet", "two.parquet"):
        words = ("--robot", "ur5", "--trajectory", swing, "--out", tmp_path / name, "--rate", 250)
        done = mjfriction_here("simulate", *words)
        assert done.returncode == 0, done.stderr
        logs.append((tmp_path / name).read_bytes())
    assert logs[0] == logs[1]
    log = read_log(tmp_path / "one.parquet")
    assert len(log.joints) == 6
    assert log.time.size == 2501
    assert log.faults == ()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["one.parquet", "swing.parquet", "two.parquet"]


def test_csv_currents_and_velocities(swing: Path, tmp_path: Path) -> None:
    out = tmp_path / "run.csv"
    words = ("--rate", 100, "--current", "--velocity")
    assert mjfriction_here("simulate", "--robot", "ur5", "--trajectory", swing, "--out", out, *words).returncode == 0
    log = read_log(out)
    assert log.channel("current", "elbow_joint") is not None
    assert log.channel("velocity", "elbow_joint") is not None


def test_a_joint_that_moves_no_mass_is_named(tmp_path: Path) -> None:
    mass = '<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'
    links = "".join(f'<link name="l{i}">{mass if i < 2 else ""}</link>' for i in range(3))
    joints = "".join(
        f'<joint name="j{i}" type="continuous"><parent link="l{i - 1}"/><child link="l{i}"/></joint>' for i in (1, 2)
    )
    (tmp_path / "arm.urdf").write_text(f'<robot name="arm">{links}{joints}</robot>')
    (tmp_path / "robot.toml").write_text(
        'name = "arm"\nmodel = "arm.urdf"\n[[joint]]\nname = "j1"\n[[joint]]\nname = "j2"\n'
    )
    pyarrow.parquet.write_table(sine("j1", 0.5, 0.6, 0.3, 3.0).table(), tmp_path / "swing.parquet")
    words = ("--trajectory", tmp_path / "swing.parquet", "--out", tmp_path / "x.csv")
    done = mjfriction_here("simulate", "--robot", tmp_path / "robot.toml", *words)
    assert done.returncode == 2
    assert "nothing that joint 'j2' moves has a mass" in done.stderr
    assert done.stderr.count("\n") == 1


def test_bad_input_is_one_line_and_leaves_nothing(swing: Path, tmp_path: Path) -> None:
    (tmp_path / "bad.csv").write_text("time,position.elbow\n0,0\n1,0\n2,0\n3,0\n")
    cases = [
        (("--trajectory", tmp_path / "bad.csv", "--out", tmp_path / "x.csv"), "no joint 'elbow'"),
        (("--trajectory", tmp_path / "none.csv", "--out", tmp_path / "x.csv"), "no such file"),
        (("--trajectory", swing, "--out", tmp_path / "x.txt"), "written as .csv or .parquet"),
    ]
    for words, message in cases:
        done = mjfriction_here("simulate", "--robot", "ur5", *words)
        assert done.returncode == 2
        assert message in done.stderr
        assert done.stderr.count("\n") == 1
    assert not list(tmp_path.glob("x.*"))


@pytest.mark.deep
def test_voltages_run_a_cylinder_and_what_it_logs_runs_it_again(tmp_path: Path) -> None:
    course, log = tmp_path / "volts.csv", tmp_path / "log.parquet"
    words = ("--robot", "hydraulic_cylinder")
    assert mjfriction_here("plan", *words, "--protocol", "voltages", "--out", course).returncode == 0
    short = tmp_path / "short.csv"
    short.write_text("\n".join(course.read_text().splitlines()[:501]) + "\n")
    done = mjfriction_here("simulate", *words, "--trajectory", short, "--out", log, "--rate", 250)
    assert done.returncode == 0, done.stderr
    columns = set(read_log(log).columns)
    named = ("position", "effort", "pressure_head", "pressure_rod", "flow_head", "flow_rod", "voltage")
    assert {f"{name}.piston" for name in named} | {"supply_pressure"} <= columns
    # A log has positions: the piston follows them, and its voltages are only recorded.
    again = mjfriction_here("simulate", *words, "--trajectory", log, "--out", tmp_path / "again.parquet", "--rate", 250)
    assert again.returncode == 0, again.stderr


def test_a_recording_of_the_run_beside_its_log(swing: Path, tmp_path: Path) -> None:
    log, recording = tmp_path / "log.parquet", tmp_path / "run.rrd"
    words = ("--robot", "ur5", "--trajectory", swing, "--out", log, "--rate", 250, "--recording", recording)
    done = mjfriction_here("simulate", *words)
    assert done.returncode == 0, done.stderr
    assert f"mjfriction view {recording}" in done.stdout
    assert recording.stat().st_size > 10_000
    assert log.is_file()


def test_a_run_that_breaks_down_says_where_and_when_and_leaves_nothing(swing: Path, tmp_path: Path) -> None:
    robot = tmp_path / "heavy.toml"
    robot.write_text(
        'name = "heavy"\nmodel = "package://example-robot-data/ur_description/urdf/ur5_robot.urdf"\n'
        '[[joint]]\nname = "elbow_joint"\nspring = { stiffness = -1e9 }\n',
        encoding="utf-8",
    )
    done = mjfriction_here("simulate", "--robot", robot, "--trajectory", swing, "--out", tmp_path / "log.csv")
    assert done.returncode == 2
    assert len(done.stderr.strip().splitlines()) == 1
    assert "out of bounds at joint 'elbow_joint' near" in done.stderr
    assert sorted(path.name for path in tmp_path.iterdir()) == ["heavy.toml", "swing.parquet"]
