"""``identify``, ``compare`` and ``plan`` as a user meets them."""

from __future__ import annotations

import json
from pathlib import Path

import jsonschema
import pyarrow as pa
import pyarrow.csv
import pyarrow.parquet
import pytest

from mjfriction.cli.compare import short_names
from mjfriction.plant.trajectory import read_trajectory
from mjfriction.robot.files import read_robot
from scripts.make_schema import schema
from tests.cli.here import mjfriction_here
from tests.hidden.machine import UR5_JOINTS, Machine, record, robot_toml

FILES = {"report.json", "report.html", "recording.rrd", "robot.toml", "ur5_robot.urdf"}


@pytest.fixture(scope="module")
def case(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    folder = tmp_path_factory.mktemp("case")
    machine = Machine(noise=0.1)
    pyarrow.parquet.write_table(pa.table(record(machine, seed=2, seconds=20.0)), folder / "log.parquet")
    (folder / "robot.toml").write_text(robot_toml(machine, off=0.3), encoding="utf-8")
    return folder / "log.parquet", folder / "robot.toml"


@pytest.fixture(scope="module")
def identified(case: tuple[Path, Path], tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("out") / "identified"
    done = mjfriction_here("identify", case[0], "--robot", case[1], "--law", "coulomb_viscous", "--out", out)
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""
    assert done.stdout.startswith("IDENTIFIED")
    assert max(len(line) for line in done.stdout.splitlines() if "/" not in line) <= 80
    return out


def test_identify_writes_four_files_that_hold_together(identified: Path) -> None:
    assert {path.name for path in identified.iterdir()} == FILES
    report = json.loads((identified / "report.json").read_text())
    jsonschema.validate(report, json.loads(schema()))
    assert report["verdict"] == "explained"
    (elbow,) = (law for law in report["identified"] if law["joint"] == "elbow_joint")
    coulomb = next(entry for entry in elbow["parameters"] if entry["name"] == "coulomb")
    assert coulomb["ci95"][0] < 7.0 < coulomb["ci95"][1]
    stated = read_robot(identified / "robot.toml").joint("elbow_joint").friction[0].parameters["coulomb"]
    assert stated == pytest.approx(coulomb["value"], rel=1e-6)
    page = (identified / "report.html").read_text()
    assert 'rel="stylesheet"' not in page  # it loads nothing


def test_compare_prints_and_writes_both_robots(case: tuple[Path, Path], identified: Path, tmp_path: Path) -> None:
    words = ("compare", case[0], "--robot", case[1], "--robot", identified / "robot.toml", "--simulated", "0.5")
    done = mjfriction_here(*words, "--out", tmp_path / "out", "--json")
    assert done.returncode == 0, done.stderr
    table = json.loads(done.stdout)
    assert table == json.loads((tmp_path / "out/comparison.json").read_text())
    assert table["best"] == "identified"
    for joint in table["joints"]:
        assert joint["rms_effort"][1] < joint["rms_effort"][0]
    assert table["simulated_seconds"] == pytest.approx(0.5)
    (elbow,) = (joint for joint in table["joints"] if joint["joint"] == "elbow_joint")
    assert elbow["rms_position"][1] < 0.5 * elbow["rms_position"][0]
    assert {path.name for path in (tmp_path / "out").iterdir()} == {"comparison.json", "report.html", "recording.rrd"}
    done = mjfriction_here(*words)
    assert done.returncode == 0, done.stderr
    assert max(len(line) for line in done.stdout.splitlines() if "/" not in line) <= 80


def test_compare_names_robots_as_shortly_as_tells_them_apart() -> None:
    assert short_names(["arm/robot.toml", "result/robot.toml", "ur5"]) == ["arm", "result", "ur5"]
    assert short_names(["a/arm/robot.toml", "b/arm/robot.toml"]) == ["a/arm/robot.toml", "b/arm/robot.toml"]
    assert short_names(["before.toml", "after.toml"]) == ["before", "after"]


def test_joints_may_have_laws_of_their_own(case: tuple[Path, Path], tmp_path: Path) -> None:
    wanted = dict.fromkeys(UR5_JOINTS, "coulomb_viscous") | {"elbow_joint": "quadratic_viscous"}
    laws = [word for joint, law in wanted.items() for word in ("--law", f"{joint}={law}")]
    done = mjfriction_here(
        "identify", case[0], "--robot", case[1], "--out", tmp_path / "out", *laws, "--no-links", "--json"
    )
    assert done.returncode == 0, done.stderr
    assert {law["joint"]: law["law"] for law in json.loads(done.stdout)["identified"]} == wanted


@pytest.mark.parametrize(
    ("laws", "said"),
    [
        (("lugre", "dahl"), "give one law for all joints, or JOINT=LAW for each"),
        (("lugre", "elbow_joint=dahl"), "--law lugre: beside JOINT=LAW every law needs its joint"),
        (("elbow_jont=dahl",), "did you mean 'elbow_joint'"),
        (("elbow_joint=dal",), "did you mean 'dahl'"),
    ],
)
def test_laws_that_make_no_sense_together_are_one_line(
    laws: tuple[str, ...], said: str, case: tuple[Path, Path], tmp_path: Path
) -> None:
    words = [word for law in laws for word in ("--law", law)]
    done = mjfriction_here("identify", case[0], "--robot", case[1], "--out", tmp_path / "out", *words)
    assert done.returncode == 2
    assert said in done.stderr
    assert done.stderr.count("\n") == 1
    assert not (tmp_path / "out").exists()


def test_plan_writes_a_trajectory(tmp_path: Path) -> None:
    out = tmp_path / "passes.csv"
    words = ("--robot", "ur5", "--protocol", "forward_backward", "--joint", "wrist_3_joint", "--speeds", 4)
    done = mjfriction_here("plan", *words, "--out", out)
    assert done.returncode == 0, done.stderr
    assert "free of gravity in some poses" in done.stdout
    assert read_trajectory(out).joints == read_robot("ur5").joints


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("plan", "--robot", "ur5", "--protocol", "separate", "--out", "t.csv"), "give it with --against"),
        (("plan", "--robot", "ur5", "--protocol", "excitation", "--out", "t.txt"), "written as .csv or .parquet"),
        (("plan", "--robot", "ur5", "--protocol", "passes", "--out", "t.csv"), "forward_backward"),
        (("identify", "LOG", "--robot", "ROBOT", "--law", "lugree", "--out", "o"), "did you mean 'lugre'"),
        (("identify", "LOG", "--robot", "ur10", "--law", "gmz", "--out", "o"), "did you mean 'gms'"),
        (("compare", "LOG", "--robot", "ROBOT", "--robot", "z1"), "same joints"),
    ],
)
def test_bad_input_is_one_line(words: tuple[str, ...], said: str, case: tuple[Path, Path], tmp_path: Path) -> None:
    places = {"LOG": case[0], "ROBOT": case[1]}
    done = mjfriction_here(*(places.get(word, word) for word in words), cwd=tmp_path)
    assert done.returncode == 2
    assert said in done.stderr
    assert len(done.stderr.strip().splitlines()) == 1
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--protocol", "excitation", "--joint", "elbow_joint"), "--joint is of the protocol 'forward_backward'"),
        (("--protocol", "forward_backward", "--seconds", "30"), "--seconds is of the protocol 'excitation'"),
    ],
)
def test_plan_refuses_options_of_another_protocol(words: tuple[str, ...], said: str, tmp_path: Path) -> None:
    done = mjfriction_here("plan", "--robot", "ur5", *words, "--out", tmp_path / "t.csv")
    assert done.returncode == 2
    assert said in done.stderr


def test_a_misspelt_column_is_not_left_out_in_silence(case: tuple[Path, Path], tmp_path: Path) -> None:
    table = pyarrow.parquet.read_table(case[0])
    names = [name.replace("effort.elbow_joint", "efort.elbow_joint") for name in table.schema.names]
    pyarrow.parquet.write_table(table.rename_columns(names), tmp_path / "log.parquet")
    done = mjfriction_here("diagnose", tmp_path / "log.parquet", "--robot", case[1], "--out", tmp_path / "out")
    assert done.returncode == 2
    assert "did you mean 'effort.elbow_joint'" in done.stderr


def test_compare_names_no_winner_where_there_is_none(case: tuple[Path, Path], tmp_path: Path) -> None:
    same = tmp_path / "same.toml"
    same.write_text(case[1].read_text())
    done = mjfriction_here("compare", case[0], "--robot", case[1], "--robot", same)
    assert done.returncode == 0, done.stderr
    assert "equally near" in done.stdout
    done = mjfriction_here("compare", case[0], "--robot", case[1])
    assert done.returncode == 2
    assert "compares with nothing" in done.stderr
