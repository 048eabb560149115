"""The report: its schema, its page and its recording."""

from __future__ import annotations

import json
import os
import re
import shutil
import signal
from collections.abc import Callable
from contextlib import AbstractContextManager
from pathlib import Path

import jsonschema
import pytest

from mjfriction.diagnose.diagnosis import diagnose_log
from mjfriction.diagnose.tell.outcome import Diagnosis
from mjfriction.errors import OutputError
from mjfriction.record.readers import read_log
from mjfriction.report.folder import whole_file, whole_folder
from mjfriction.report.html import report_html
from mjfriction.report.result import Report, make_report, report_json
from mjfriction.report.write import SOMETIMES, write_results
from mjfriction.robot.files import read_robot
from scripts.make_schema import schema
from tests.hidden.machine import Machine, write_case

PACKAGE = Path(__file__).resolve().parents[2] / "mjfriction"

EXAMPLE = """
{ "schema": "mjfriction.report/1", "verdict": "explained", "summary": "one sentence",
  "joints": [ { "joint": "elbow_joint", "signal": "effort", "unit": "N·m", "rms_before": 3.1, "rms_after": 0.62,
                "rms_heldout_before": 3.0, "rms_heldout_after": 0.64, "noise_floor": 0.6 } ],
  "findings": [ { "cause": "friction.load", "joint": "elbow_joint", "confidence": 0.99, "alternatives": [],
                  "parameters": [ { "name": "load", "value": 0.121, "unit": "1", "ci95": [0.117, 0.125] } ],
                  "gain": { "rms_before": 3.0, "rms_after": 0.64, "reduction": 0.79, "ci95": [0.77, 0.80] },
                  "evidence": "one sentence: where in the data it shows" } ],
  "next_experiment": null,
  "data_problems": [ { "kind": "data.gap", "where": "12.48 s to 12.61 s", "action": "split there" } ] }"""


@pytest.fixture(scope="module")
def diagnosis(tmp_path_factory: pytest.TempPathFactory) -> Diagnosis:
    machine = Machine(hidden={2: lambda i: 2.0 * abs(i.v)})
    log, robot = write_case(tmp_path_factory.mktemp("case"), machine, seed=2, seconds=20.0)
    return diagnose_log(read_log(log), read_robot(robot))


def test_the_schema_ships_and_is_the_models_own() -> None:
    assert (PACKAGE / "report/report.schema.json").read_text(encoding="utf-8") == schema()


def test_a_report_keeps_to_the_schema_and_reads_back(diagnosis: Diagnosis) -> None:
    text = report_json(make_report(diagnosis))
    jsonschema.validate(json.loads(text), json.loads(schema()))
    assert Report.model_validate_json(text).findings[0].cause == "friction.asymmetry"


def test_the_documented_example_is_a_report() -> None:
    jsonschema.validate(json.loads(EXAMPLE), json.loads(schema()))
    assert Report.model_validate_json(EXAMPLE).verdict == "explained"
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate(json.loads(EXAMPLE.replace("explained", "solved")), json.loads(schema()))


def test_the_page_holds_all_it_shows(diagnosis: Diagnosis) -> None:
    page = report_html(diagnosis, make_report(diagnosis))
    without_script = re.sub(r"<script.*?</script>", "", page, flags=re.DOTALL)
    assert not re.search(r"(src|href)=\"(?!data:)", without_script)
    assert "friction.asymmetry" in without_script
    figures = list(re.findall(r'<div id="([a-z0-9-]+)" class="plotly-graph-div"', page))
    assert figures == ["errors", "finding-0", "course-0", "driven-0"]
    for joint in diagnosis.joints:
        assert joint.joint in without_script


def test_every_joints_reduction_has_an_interval_that_tells_gain_from_none(diagnosis: Diagnosis) -> None:
    page = report_html(diagnosis, make_report(diagnosis))
    for error in diagnosis.joints:
        low, high = error.reduction_ci95
        gained = 1.0 - error.rms_heldout_after / error.rms_heldout_before
        assert low - 1e-12 <= gained <= high + 1e-12
        assert (low > 0.2) is (error.joint == "elbow_joint"), "what is hidden is hidden there"
        shown = f"({round(100 * low)} … {round(100 * high)})"
        (row,) = re.findall(rf"<tr><td>{error.joint}</td>[^\n]*\n<td>[^\n]* \({error.signal}\)</td></tr>", page)
        assert (shown in row) is (error.rms_heldout_after != error.rms_heldout_before)


def test_the_page_tells_where_both_robots_go_when_driven_freely(diagnosis: Diagnosis) -> None:
    report = make_report(diagnosis)
    assert report.simulation is not None
    page = report_html(diagnosis, report).split('id="driven"')[1]
    for drift in report.simulation.joints:
        assert drift.ci95[0] <= drift.reduction <= drift.ci95[1]
        figures = "".join(f"<td>{1e3 * value:.4g}</td>" for value in (drift.rms_before, drift.rms_after))
        assert f"<tr><td>{drift.joint}</td>{figures}" in page
    most = max(report.simulation.joints, key=lambda drift: drift.reduction)
    assert most.joint == "elbow_joint", "what is hidden is hidden there"
    assert "elbow_joint ends up" in report.driven
    assert report.driven.replace("'", "&#39;") in page


def test_the_page_tells_what_the_error_follows_before_any_cause_is_assumed(diagnosis: Diagnosis) -> None:
    page = report_html(diagnosis, make_report(diagnosis))
    rows = dict(re.findall(r"<tr><td>(\w+)</td>((?:<td>[^\n]*? → [^\n]*?</td>)+)</tr>", page.split('id="followed"')[1]))
    assert set(rows) == {error.joint for error in diagnosis.joints}
    marked = {joint: row.count("<strong>") for joint, row in rows.items()}
    assert marked.pop("elbow_joint") > 0
    assert not any(marked.values())


def test_equal_inputs_give_equal_bytes(diagnosis: Diagnosis, tmp_path: Path) -> None:
    again = diagnose_log(diagnosis.gap.log, diagnosis.gap.robot)
    for name, result in (("one", diagnosis), ("two", again)):
        (tmp_path / name).mkdir()
        write_results(result, make_report(result), tmp_path / name)
    names = sorted(path.name for path in (tmp_path / "one").iterdir())
    assert {"report.json", "report.html", "recording.rrd", "robot.toml"} <= set(names)
    for name in names:
        if name != "recording.rrd":  # Rerun numbers its chunks by the clock
            assert (tmp_path / "one" / name).read_bytes() == (tmp_path / "two" / name).read_bytes(), name


def test_results_appear_whole_or_not_at_all(tmp_path: Path) -> None:
    target = tmp_path / "out"

    def fail_half_way() -> None:
        with whole_folder(target) as folder:
            (folder / "report.json").write_text("{")
            raise RuntimeError("half way")

    with pytest.raises(RuntimeError):
        fail_half_way()
    assert list(tmp_path.iterdir()) == []
    with whole_folder(target) as folder:
        (folder / "a").write_text("new")
        assert not target.exists()
    assert [path.name for path in tmp_path.iterdir()] == ["out"]
    (target / "mine").write_text("kept")
    with whole_folder(target) as folder:
        (folder / "a").write_text("newer")
    assert {path.name: path.read_text() for path in target.iterdir()} == {"a": "newer", "mine": "kept"}
    with whole_file(tmp_path / "table.parquet") as draft:
        draft.write_text("x")
        assert not (tmp_path / "table.parquet").exists()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["out", "table.parquet"]


def test_what_an_earlier_run_left_and_this_one_does_not_write_goes(tmp_path: Path) -> None:
    target = tmp_path / "out"
    target.mkdir()
    for name in ("next_experiment.parquet", "notes.txt", "report.json"):
        (target / name).write_text("old")
    with whole_folder(target, SOMETIMES) as folder:
        (folder / "report.json").write_text("new")
        assert (target / "next_experiment.parquet").exists(), "until all is written"
    assert {path.name: path.read_text() for path in target.iterdir()} == {"notes.txt": "old", "report.json": "new"}


def test_a_place_that_cannot_be_written_is_named(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    for place in (tmp_path / "file", tmp_path / "file" / "below"):
        with pytest.raises(OutputError, match=r"give a"), whole_folder(place):
            pass
    with pytest.raises(OutputError, match="cannot be written"), whole_file(tmp_path / "file" / "p.parquet"):
        pass


def test_an_interrupt_as_the_folder_is_made_leaves_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    mkdir = Path.mkdir

    def interrupted(path: Path, mode: int = 0o777, parents: bool = False, exist_ok: bool = False) -> None:
        mkdir(path, mode, parents, exist_ok)
        if path.parent == tmp_path:
            raise KeyboardInterrupt

    monkeypatch.setattr(Path, "mkdir", interrupted)
    with pytest.raises(KeyboardInterrupt), whole_folder(tmp_path / "out"):
        pass
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("whole", [whole_folder, whole_file])
def test_a_second_interrupt_does_not_cut_the_putting_away_short(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, whole: Callable[[Path], AbstractContextManager[Path]]
) -> None:
    rmtree, unlink = shutil.rmtree, Path.unlink

    def pressed_again(take_away: Callable[..., None]) -> Callable[..., None]:
        def taking(*words: object, **options: object) -> None:
            os.kill(os.getpid(), signal.SIGINT)
            take_away(*words, **options)

        return taking

    monkeypatch.setattr(shutil, "rmtree", pressed_again(rmtree))
    monkeypatch.setattr(Path, "unlink", pressed_again(unlink))
    heeded = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        with pytest.raises(KeyboardInterrupt), whole(tmp_path / "out"):
            raise KeyboardInterrupt
        assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    finally:
        signal.signal(signal.SIGINT, heeded)
    assert list(tmp_path.iterdir()) == []
