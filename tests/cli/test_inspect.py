"""``mjfriction inspect``: what is in a log; and columns by foreign names, in every verb that reads one."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.csv
import pytest

from tests.cli.here import mjfriction_here
from tests.hidden.machine import UR5_JOINTS, Machine, record, robot_toml


@pytest.fixture(scope="module")
def case(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("inspect")
    columns = record(Machine(), 3, 15.0)
    pyarrow.csv.write_csv(pa.table(columns), folder / "log.csv")
    foreign = {"t_ms": 1e3 * columns["time"]}
    for i, joint in enumerate(UR5_JOINTS):
        foreign[f"actual_q_{i}"] = columns[f"position.{joint}"]
        foreign[f"actual_tau_{i}"] = columns[f"effort.{joint}"]
        foreign[f"target_q_{i}"] = 0.0 * columns["time"]
    pyarrow.csv.write_csv(pa.table(foreign), folder / "foreign.csv")
    (folder / "robot.toml").write_text(robot_toml(Machine()), encoding="utf-8")
    return folder


@pytest.mark.deep
def test_a_log_alone(case: Path) -> None:
    done = mjfriction_here("inspect", case / "log.csv")
    assert done.returncode == 0, done.stderr
    assert "3750 rows, 15 s at 250 Hz" in done.stdout
    for joint in UR5_JOINTS:
        assert joint in done.stdout
    assert "With --robot R this also says what the log could show" in done.stdout
    assert max(map(len, done.stdout.splitlines()[1:])) <= 80


def test_a_log_and_its_robot(case: Path) -> None:
    done = mjfriction_here("inspect", case / "log.csv", "--robot", case / "robot.toml")
    assert done.returncode == 0, done.stderr
    assert "friction.stribeck" in done.stdout
    assert "hydraulic.pressure" in done.stdout.split("for want of a column:")[1]
    machine = mjfriction_here("inspect", case / "log.csv", "--robot", case / "robot.toml", "--json")
    told = json.loads(machine.stdout)
    assert [joint["joint"] for joint in told["joints"]] == list(UR5_JOINTS)
    assert all(one["least"] > 0.0 for one in told["could_show"])


@pytest.mark.parametrize(("factor", "kind", "mended"), [(-1.0, "data.sign", True), (37.0, "data.unit", False)])
def test_a_log_that_reads_wrong_shows_nothing_unless_it_is_mended(
    factor: float, kind: str, mended: bool, case: Path, tmp_path: Path
) -> None:
    table = pyarrow.csv.read_csv(case / "log.csv")
    name = "effort.elbow_joint"
    wrong = table.set_column(table.schema.get_field_index(name), name, pa.array(factor * table[name].to_numpy()))
    pyarrow.csv.write_csv(wrong, tmp_path / "log.csv")
    done = mjfriction_here("inspect", tmp_path / "log.csv", "--robot", case / "robot.toml")
    assert done.returncode == 0, done.stderr
    assert f"{kind}: {name}" in done.stdout
    assert ("once the log reads right" in done.stdout) is not mended
    assert ("friction.stribeck" in done.stdout) is mended
    assert ("read so here" in done.stdout) is mended


def test_foreign_names_are_shown_confirmed_and_used(case: Path, tmp_path: Path) -> None:
    log, robot, kept = case / "foreign.csv", case / "robot.toml", tmp_path / "columns.toml"
    refused = mjfriction_here("predict", log, "--robot", robot, "--out", tmp_path / "p.parquet")
    assert refused.returncode == 2
    assert "column 'time' is missing" in refused.stderr
    assert "time from 't_ms'" in refused.stderr
    assert "--map guess" in refused.stderr
    assert len(refused.stderr.strip().splitlines()) == 1
    shown = mjfriction_here("inspect", log, "--robot", robot, "--write-map", kept)
    assert shown.returncode == 0, shown.stderr
    assert "position.elbow_joint  from 'actual_q_2'" in shown.stdout
    assert "time  from 't_ms' times 0.001" in shown.stdout
    results = []
    for name, mapping in (("guess", "guess"), ("file", kept), ("plain", None)):
        out = tmp_path / f"{name}.parquet"
        words = () if mapping is None else ("--map", mapping)
        source = log if mapping is not None else case / "log.csv"
        done = mjfriction_here("predict", source, "--robot", robot, "--out", out, *words)
        assert done.returncode == 0, done.stderr
        results.append(done.stdout)
    assert results[0] == results[1] == results[2]


@pytest.mark.parametrize(("tick", "unit"), [(1e6, "µs"), (1e9, "ns"), (1e3, "ms"), (1.0, "s")])
def test_a_clock_whose_name_tells_no_unit_goes_by_its_steps(tick: float, unit: str, case: Path, tmp_path: Path) -> None:
    table = pyarrow.csv.read_csv(case / "foreign.csv")
    clock = np.round(tick * 1e-3 * table["t_ms"].to_numpy(), 6)
    table = table.drop_columns(["t_ms"]).append_column("timestamp", pa.array(clock))
    pyarrow.csv.write_csv(table, tmp_path / "log.csv")
    shown = mjfriction_here("inspect", tmp_path / "log.csv", "--robot", case / "robot.toml", "--json")
    assert shown.returncode == 0, shown.stderr
    told = json.loads(shown.stdout)
    assert told["rate"] == pytest.approx(250.0)
    assert told["guessed_columns"]["time"]["scale"] == pytest.approx(1.0 / tick), unit


def test_a_mapping_is_kept_even_where_the_log_cannot_be_read_by_it(case: Path, tmp_path: Path) -> None:
    table = pyarrow.csv.read_csv(case / "foreign.csv")
    slow = 1e9 * np.arange(table.num_rows)  # no unit makes that a log
    table = table.drop_columns(["t_ms"]).append_column("timestamp", pa.array(slow))
    pyarrow.csv.write_csv(table, tmp_path / "log.csv")
    kept = tmp_path / "columns.toml"
    done = mjfriction_here("inspect", tmp_path / "log.csv", "--robot", case / "robot.toml", "--write-map", kept)
    assert done.returncode == 2
    assert "time must be in seconds" in done.stderr
    assert "timestamp" in kept.read_text()


def test_there_is_nothing_to_guess(case: Path, tmp_path: Path) -> None:
    done = mjfriction_here("inspect", case / "log.csv", "--write-map", tmp_path / "columns.toml")
    assert done.returncode == 2
    assert "no columns to guess" in done.stderr
    assert list(tmp_path.iterdir()) == []


@pytest.mark.deep
def test_names_that_tell_nothing_give_a_mapping_to_fill_in(case: Path, tmp_path: Path) -> None:
    columns = (case / "log.csv").read_text().splitlines()
    names = columns[0].replace('"', "").split(",")
    odd = tmp_path / "odd.csv"
    odd.write_text("\n".join([",".join(f"c{chr(97 + k)}" for k in range(len(names))), *columns[1:]]) + "\n")
    kept = tmp_path / "columns.toml"
    done = mjfriction_here("inspect", odd, "--robot", case / "robot.toml", "--write-map", kept)
    assert done.returncode == 0, done.stderr
    assert "ca, cb" in done.stdout
    assert "fill it in, and give it with --map" in " ".join(done.stdout.split())
    text = kept.read_text()
    assert "#   ca" in text
    done = mjfriction_here("inspect", odd, "--robot", case / "robot.toml", "--map", kept)
    assert "names no column" in done.stderr
    # Filled in with the right columns, it is what was meant.
    for k, name in enumerate(names):
        text = text.replace(f'# "{name}" = "..."', f'"{name}" = "c{chr(97 + k)}"')
    kept.write_text(text)
    done = mjfriction_here("predict", odd, "--robot", case / "robot.toml", "--out", tmp_path / "p.csv", "--map", kept)
    assert done.returncode == 0, done.stderr
    assert "RMS error" in done.stdout
