"""Running a tool on a case: any command with the verbs ``diagnose`` and ``predict`` can be scored."""

from __future__ import annotations

import json
import math
import subprocess
import time
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet

from mjfriction.benchmark.cases import Case, write_case
from mjfriction.benchmark.score import Finding, Named, Outcome, removed_share
from mjfriction.errors import BenchmarkError
from mjfriction.laws.law import Floats
from mjfriction.record.readers.table import log_from_table
from mjfriction.robot.predict import predict_log
from mjfriction.robot.robot import Robot


def run_tool(command: Sequence[str], case: Case, folder: Path) -> Outcome:
    """Run ``command diagnose LOG --robot R --out DIR`` on a case, then ``command predict`` along its other motion.

    Everything is written into ``folder``, where the case is too; the tool is given ``log.parquet`` and ``robot.toml``.
    A tool that fails counts as having found and removed nothing; its verdict is ``failed: `` and the error, with the
    last line that the tool printed.
    """
    if not (folder / "log.parquet").is_file():
        write_case(case, folder)
    hidden: dict[bool, list[Named]] = {True: [], False: []}
    for one in case.hidden:
        if not one.outside:
            hidden[not one.faint].append((one.cause, one.joint))
    outside = tuple((one.cause, one.joint) for one in case.hidden if one.outside and not one.faint)
    asked = bool(hidden[True]) and not outside
    begin = time.perf_counter()
    try:
        found, verdict = _diagnosed(command, folder)
        seconds = time.perf_counter() - begin
        removed = _removed(command, case, folder) if asked else None
    except BenchmarkError as error:
        found, verdict, removed, seconds = (), f"failed: {error}", 0.0 if asked else None, math.nan
    return Outcome(tuple(hidden[True]), found, verdict, removed, seconds, tuple(hidden[False]), outside)


def _diagnosed(command: Sequence[str], folder: Path) -> tuple[tuple[Finding, ...], str]:
    out = folder / "out"
    _called(command, "diagnose", folder / "log.parquet", folder / "robot.toml", out)
    report = json.loads((out / "report.json").read_text(encoding="utf-8"))
    found = [Finding(f["cause"], f["joint"], f["confidence"], tuple(f["alternatives"])) for f in report["findings"]]
    return tuple(found), report["verdict"]


def _removed(command: Sequence[str], case: Case, folder: Path) -> float | None:
    told = folder / "told.parquet"
    _called(command, "predict", folder / "truth" / "other.parquet", folder / "out" / "robot.toml", told)
    table = pyarrow.parquet.read_table(told)
    names = [name for name in table.column_names if name != "time"]
    measured = np.column_stack([case.other[name] for name in names])
    extended = np.column_stack([table[name] for name in names])
    stated, machine = (_predicted(case, robot, names) for robot in (case.stated, case.machine))
    return removed_share(measured, stated, extended, machine)


def _predicted(case: Case, robot: Robot, names: Sequence[str]) -> Floats:
    columns = predict_log(log_from_table(pa.table(case.other), "the other motion"), robot)
    return np.column_stack([columns[name] for name in names])


def _called(command: Sequence[str], verb: str, log: Path, robot: Path, out: Path) -> None:
    words = [*command, verb, str(log), "--robot", str(robot), "--out", str(out)]
    done = subprocess.run(words, check=False, capture_output=True, text=True)
    if done.returncode != 0:
        last = (done.stderr.strip().splitlines() or ["it said nothing"])[-1]
        raise BenchmarkError(f"'{' '.join(command)} {verb}' failed with exit status {done.returncode}: {last}")
