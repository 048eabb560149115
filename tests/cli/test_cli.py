"""The command as a user meets it: exit statuses, one line on standard error, nothing left behind."""

from __future__ import annotations

import contextlib
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import jsonschema
import numpy as np
import pyarrow as pa
import pyarrow.parquet
import pytest
import typer

from mjfriction.cli.main import app
from mjfriction.record.readers import read_log
from scripts.make_schema import schema
from tests.cli.here import mjfriction_here
from tests.hidden.machine import UR5_JOINTS, Machine, record, robot_toml


def mjfriction(*words: object, cwd: Path | None = None) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-c", "from mjfriction.cli.main import run; run()", *map(str, words)]
    return subprocess.run(command, check=False, capture_output=True, text=True, cwd=cwd, timeout=120)


@pytest.fixture(scope="module")
def good(tmp_path_factory: pytest.TempPathFactory) -> tuple[dict[str, np.ndarray], str]:
    machine = Machine(hidden={2: lambda i: 2.0 * np.abs(i.v)})
    return record(machine, seed=2, seconds=20.0), robot_toml(machine)


def place(folder: Path, good: tuple[dict[str, np.ndarray], str], **changed: object) -> tuple[Path, Path]:
    table, robot = dict(good[0]), good[1]
    table |= changed.pop("table", {})  # type: ignore[call-overload]
    robot = str(changed.pop("robot", robot))
    rows = changed.pop("rows", None)
    pyarrow.parquet.write_table(
        pa.table({k: v[:rows] for k, v in table.items() if v is not None}), folder / "log.parquet"
    )
    (folder / "robot.toml").write_text(robot, encoding="utf-8")
    return folder / "log.parquet", folder / "robot.toml"


def test_ctrl_c_leaves_nothing_and_says_so(tmp_path: Path, good: tuple[dict[str, np.ndarray], str]) -> None:
    log, robot = place(tmp_path, good)
    words = ["diagnose", str(log), "--robot", str(robot), "--out", str(tmp_path / "out")]
    # Run in the background of a shell, the tests hand down that an interrupt is to be ignored.
    heeded = "import signal; signal.signal(signal.SIGINT, signal.default_int_handler)"
    command = [sys.executable, "-c", f"{heeded}; from mjfriction.cli.main import run; run()", *words]
    running = subprocess.Popen(command, stderr=subprocess.PIPE, text=True, start_new_session=True)
    until = time.monotonic() + 60.0
    while len(list(tmp_path.iterdir())) < 3 and time.monotonic() < until:  # the folder being made, beside the two
        time.sleep(0.02)
    # One that falls into a callback of a library is dropped by Python: a person presses the keys again.
    told = None
    while told is None:
        os.killpg(running.pid, signal.SIGINT)
        with contextlib.suppress(subprocess.TimeoutExpired):
            _, told = running.communicate(timeout=1.0)
    assert running.returncode == 130
    assert told.strip() == "mjfriction: stopped; nothing was written"
    assert {path.name for path in tmp_path.iterdir()} == {log.name, robot.name}


def test_keys_pressed_again_while_it_ends_change_nothing() -> None:
    code = """
import os, signal, sys
from mjfriction.cli import main

class Pressed:
    def write(self, text):
        os.kill(os.getpid(), signal.SIGINT)
        sys.__stderr__.write(text)
    def flush(self):
        sys.__stderr__.flush()

def interrupted(*words, **options):
    raise KeyboardInterrupt

signal.signal(signal.SIGINT, signal.default_int_handler)
main.core.TyperGroup.main = interrupted
sys.argv, sys.stderr = ["mjfriction", "laws"], Pressed()
main.run()
"""
    ended = subprocess.run([sys.executable, "-c", code], check=False, capture_output=True, text=True)
    assert (ended.returncode, ended.stderr.strip()) == (130, "mjfriction: stopped; nothing was written")


@pytest.mark.parametrize(("own", "threads"), [({}, "1"), ({"OPENBLAS_NUM_THREADS": "3"}, "3")])
def test_matrices_take_one_thread_unless_told_otherwise(own: dict[str, str], threads: str) -> None:
    # What is set once numpy is loaded is too late.
    code = (
        "import os, sys; import mjfriction.cli.main; print(os.environ['OPENBLAS_NUM_THREADS'], 'numpy' in sys.modules)"
    )
    inherited = {name: value for name, value in os.environ.items() if name != "OPENBLAS_NUM_THREADS"}
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, env=inherited | own)
    assert out.stdout.split() == [threads, "False"]


def test_without_a_word_it_shows_its_help() -> None:
    bare, asked = mjfriction_here(), mjfriction_here("--help")
    assert bare.returncode == asked.returncode == 0
    assert bare.stdout == asked.stdout
    assert "diagnose" in bare.stdout


def test_diagnose_then_predict(tmp_path: Path, good: tuple[dict[str, np.ndarray], str]) -> None:
    log, robot = place(tmp_path, good)
    out = tmp_path / "out"
    run = mjfriction("diagnose", log, "--robot", robot, "--out", out)
    assert run.returncode == 0, run.stderr
    assert run.stderr == ""
    assert run.stdout.startswith("EXPLAINED")
    # A place that was given is not broken across lines, so that it can be copied.
    assert max(len(line) for line in run.stdout.splitlines() if str(out) not in line) <= 80
    assert {path.name for path in out.iterdir()} == {
        "report.json", "report.html", "recording.rrd", "robot.toml", "ur5_robot.urdf"
    }  # fmt: skip
    errors = []
    for source in (robot, out / "robot.toml"):
        run = mjfriction_here("predict", log, "--robot", source, "--out", tmp_path / "p.parquet", "--json")
        assert run.returncode == 0, run.stderr
        errors.append(json.loads(run.stdout)["columns"]["effort.elbow_joint"])
    assert errors[1]["rms_error"] < 0.9 * errors[0]["rms_error"]
    assert errors[0]["rms_moving"] > 1.3 * errors[0]["noise_floor"]
    assert errors[1]["rms_moving"] < 1.1 * errors[1]["noise_floor"]
    predicted = pyarrow.parquet.read_table(tmp_path / "p.parquet")
    assert predicted.schema.names == ["time", *(f"effort.{joint}" for joint in UR5_JOINTS)]
    assert predicted.num_rows == read_log(log).time.size


def test_json_is_the_report(tmp_path: Path, good: tuple[dict[str, np.ndarray], str]) -> None:
    log, robot = place(tmp_path, good)
    run = mjfriction_here("diagnose", log, log, "--robot", robot, "--out", tmp_path / "out", "--json")
    assert run.returncode == 0, run.stderr
    jsonschema.validate(json.loads(run.stdout), json.loads(schema()))
    assert run.stdout == (tmp_path / "out" / "report.json").read_text(encoding="utf-8")


def test_demo_names_the_hidden_cause_and_proves_it(tmp_path: Path) -> None:
    run = mjfriction("demo", "--out", "here", cwd=tmp_path)
    assert run.returncode == 0, run.stderr
    assert "friction.stribeck at elbow_joint" in run.stdout
    report = json.loads((tmp_path / "here/report.json").read_text(encoding="utf-8"))
    assert [finding["cause"] for finding in report["findings"]] == ["friction.stribeck"]
    proof = next(line.split() for line in run.stdout.splitlines()[-6:] if "elbow_joint" in line)
    assert float(proof[4]) < 0.5 * float(proof[2])
    # What the page says can be done with it: diagnose the log again.
    assert read_log(tmp_path / "here/log.parquet").joints == UR5_JOINTS


constant = {f"position.{joint}": np.zeros(5000) for joint in UR5_JOINTS}
ALREADY = (None, None)
twice = np.append(0.0, np.arange(4999) * 0.004)
absent = np.full(5000, np.nan)
WRONG = {
    "missing file": ({}, ("absent.parquet", None), "absent.parquet: there is no such file"),
    "empty table": ({"rows": 0}, ALREADY, "the table is empty"),
    "two rows only": ({"rows": 2}, ALREADY, "2 rows are too few"),
    "missing time": ({"table": {"time": None}}, ALREADY, "column 'time' is missing"),
    "doubled time": ({"table": {"time": twice}}, ALREADY, "row 2: time 0 s is doubled"),
    "NaN": ({"table": {"position.elbow_joint": absent}}, ALREADY, "row 1, column 'position.elbow_joint' is nan"),
    "unknown joint": (
        {"table": {"position.elbow_jont": np.zeros(5000), "position.elbow_joint": None}},
        ALREADY,
        "did you mean 'position.elbow_jont'",
    ),
    "constant position": ({"table": constant}, ALREADY, "every position is constant"),
    "another robot": ({}, (None, "linear_axis"), "this looks like a log of another robot"),
    "misspelt key": ({"robot": 'nam = "x"'}, ALREADY, "unknown key 'nam'; did you mean 'name'?"),
    "model that does not parse": (
        {"robot": 'name = "x"\nmodel = "log.parquet"\n[[joint]]\nname = "a"\n'},
        (None, None),
        "log.parquet: not well-formed XML",
    ),
    "unwritable folder": ({}, (None, None, "robot.toml/below"), "cannot be written"),
}  # fmt: skip


@pytest.mark.parametrize("name", WRONG)
def test_wrong_input_is_one_line_and_leaves_nothing(
    name: str, tmp_path: Path, good: tuple[dict[str, np.ndarray], str]
) -> None:
    changed, (other_log, other_robot, *other_out), message = WRONG[name]
    log, robot = place(tmp_path, good, **changed)
    before = sorted(tmp_path.iterdir())
    out = tmp_path / (other_out[0] if other_out else "out")
    run = mjfriction_here("diagnose", tmp_path / (other_log or log.name), "--robot", other_robot or robot, "--out", out)
    assert run.returncode == 2, (run.stdout, run.stderr)
    assert run.stdout == ""
    assert run.stderr.startswith("mjfriction: ")
    assert run.stderr.count("\n") == 1
    assert message in run.stderr
    assert sorted(tmp_path.iterdir()) == before


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["diagnos"], "No such command 'diagnos'"),
        (["diagnose", "--robt", "x"], "No such option: --robt"),
        (["diagnose", "a.csv", "--robot", "ur5"], "Missing option '--out'"),
        (["predict", "a.csv", "--robot", "ur5", "--out", "p.xls"], ".csv or .parquet"),
        (["view", "nowhere"], "there is no such recording"),
    ],
)
def test_wrong_words_are_one_line(words: list[str], message: str, tmp_path: Path) -> None:
    run = mjfriction_here(*words, cwd=tmp_path)
    assert run.returncode == 2
    assert run.stderr.count("\n") == 1
    assert message in run.stderr
    assert list(tmp_path.iterdir()) == []


def test_every_verb_shows_an_example() -> None:
    group = typer.main.get_command(app)
    assert isinstance(group, typer.core.TyperGroup)
    assert len(group.commands) >= 14
    for verb, command in group.commands.items():
        assert f"Example: mjfriction {verb}" in str(command.help)
    assert "Example: mjfriction view" in mjfriction("view", "--help").stdout


def test_the_package_runs_as_the_command_does() -> None:
    command = [sys.executable, "-m", "mjfriction", "--version"]
    said = subprocess.run(command, check=True, capture_output=True, text=True, timeout=120).stdout
    assert said == mjfriction("--version").stdout


def test_version() -> None:
    assert mjfriction("--version").stdout.startswith("mjfriction 0.")
