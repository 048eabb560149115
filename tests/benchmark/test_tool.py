"""Tools are commands: any that keeps to the contract is scored, one that fails has found nothing."""

from __future__ import annotations

import shlex
import sys
from pathlib import Path

import pytest

from mjfriction.benchmark.cases import Case, Setting, draw_of, make_case
from mjfriction.benchmark.row import Row
from mjfriction.benchmark.score import Outcome
from mjfriction.benchmark.tool import run_tool

OURS = f"{shlex.quote(sys.executable)} -c 'from mjfriction.cli.main import run; run()'"
ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="module")
def case() -> Case:
    return make_case(12, Setting("linear_axis", seconds=30.0, rate=250.0, noise=0.1), (draw_of("drive.cogging"),), 4.0)


def outcome(command: str, case: Case, folder: Path) -> Outcome:
    return run_tool(shlex.split(command), case, folder)


@pytest.mark.deep
def test_ours_names_the_cause_and_removes_what_can_be_removed(case: Case, tmp_path: Path) -> None:
    found = outcome(OURS, case, tmp_path)
    assert found.exact
    assert found.hit
    assert found.false_alarms == ()
    assert found.removed == pytest.approx(1.0, abs=0.05)
    assert found.seconds > 0.0
    row = Row(12, {"robot": "linear_axis"}, "large", {"drive.cogging axis": 4.0}, {"ours": found})
    assert Row.read(row.line()) == row
    assert row.ours is found


@pytest.mark.deep
def test_the_naive_tool_is_scored_alike(case: Case, tmp_path: Path, monkeypatch) -> None:
    monkeypatch.chdir(ROOT)
    found = outcome(f"{shlex.quote(sys.executable)} -m scripts.naive_baseline", case, tmp_path)
    assert ("drive.cogging", "axis") in {(f.cause, f.joint) for f in found.found}
    assert found.removed is not None
    assert found.removed > 0.3


def test_a_tool_that_fails_has_found_nothing(case: Case, tmp_path: Path) -> None:
    found = outcome(f"{shlex.quote(sys.executable)} -c 'raise SystemExit(\"out of ideas\")'", case, tmp_path)
    assert found.found == ()
    assert not found.hit
    assert found.removed == 0.0
    assert found.verdict.startswith("failed: ")
    assert found.verdict.endswith("out of ideas")
