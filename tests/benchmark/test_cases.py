"""Cases of the benchmark: what was asked for is hidden, and the diagnosis of closed-loop logs finds it."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pyarrow as pa
import pytest

from mjfriction.benchmark import cases
from mjfriction.benchmark.cases import FAINT, SEVERITY, Case, Setting, draw_of, make_case, write_case
from mjfriction.benchmark.drawing import draw_case
from mjfriction.benchmark.effects.catalog import EFFECTS, Draw
from mjfriction.benchmark.score import Finding, Outcome, score
from mjfriction.diagnose.diagnosis import diagnose_log
from mjfriction.diagnose.search import as_known, refusal
from mjfriction.diagnose.tell.outcome import Diagnosis, Verdict
from mjfriction.errors import SimulationError
from mjfriction.record.readers import read_log
from mjfriction.record.readers.table import log_from_table
from mjfriction.robot.files import read_robot
from tests.deep import deep

SHORT = Setting(seconds=40.0, rate=250.0)


def diagnosed(case: Case) -> Diagnosis:
    return diagnose_log(log_from_table(pa.table(case.log), "case"), case.stated)


def named(diagnosis: Diagnosis) -> set[tuple[str, str | None]]:
    return {(finding.cause, finding.joint) for finding in diagnosis.findings}


@pytest.mark.deep
@pytest.mark.parametrize("draw", EFFECTS, ids=lambda draw: draw.__name__)
def test_an_effect_does_nothing_at_no_strength_and_stands_out_as_asked(draw) -> None:
    setting = Setting(seconds=12.0, rate=250.0, noise=0.05)
    (hidden,) = make_case(5, setting, (draw,), 1.0).hidden
    hard_to_see = {"elasticity", "rotor_inertia"}
    assert hidden.severity > (0.0 if draw.__name__ in hard_to_see else 0.5)
    assert hidden.severity < 1.6


@pytest.mark.deep
def test_the_same_seed_makes_the_same_case_and_its_folder_can_be_diagnosed(tmp_path: Path) -> None:
    first, again = (make_case(3, SHORT, (draw_of("friction.load"),), 2.0) for _ in range(2))
    for name, values in first.log.items():
        assert values.tobytes() == again.log[name].tobytes()
    write_case(first, tmp_path / "case")
    truth = json.loads((tmp_path / "case/truth/truth.json").read_text())
    (hidden,) = truth["hidden"]
    assert hidden["cause"] == "friction.load"
    diagnosis = diagnose_log(read_log(tmp_path / "case/log.parquet"), read_robot(tmp_path / "case/robot.toml"))
    assert named(diagnosis) == {("friction.load", hidden["joint"])}


@pytest.mark.parametrize(
    ("cause", "off"),
    [
        ("friction.stribeck", 0.03),
        *(
            deep(cause, off)
            for cause, off in (
                ("body.payload", 0.03),
                ("friction.presliding", 0.0),
                ("sensor.delay", 0.0),
                ("event.change", 0.03),
                ("friction.temperature", 0.0),
                ("drive.torque_constant", 0.03),
                ("drive.coupling", 0.0),
                ("body.link_inertia", 0.03),
                ("sensor.encoder_offset", 0.0),
            )
        ),
    ],
)
def test_a_hidden_effect_is_named_at_its_joint(cause: str, off: float) -> None:
    setting = Setting(seconds=40.0, rate=250.0, off=off)
    case = make_case(17, setting, (draw_of(cause),), SEVERITY["large"])
    diagnosis = diagnosed(case)
    assert named(diagnosis) == {(hidden.cause, hidden.joint) for hidden in case.hidden}


@pytest.mark.deep
def test_a_messy_log_keeps_its_finding() -> None:
    # A gap, a block sent twice, single wild samples and an uneven clock: said, and no obstacle.
    case = make_case(17, Setting(seconds=40.0, rate=250.0, off=0.03), (draw_of("friction.load"),), SEVERITY["large"])
    rng = np.random.default_rng(2)
    count = case.log["time"].size
    rows = np.r_[0:3000, 3080:6000, 5990:count]
    messy = {name: values[rows].copy() for name, values in case.log.items()}
    messy["time"] += np.where(np.diff(messy["time"], prepend=-1.0) > 0.0, rng.uniform(0.0, 4e-4, rows.size), 0.0)
    messy["time"][5920:5930] = messy["time"][5910:5920]
    for name in [name for name in messy if name.startswith("effort.")]:
        messy[name][rng.integers(200, rows.size, 5)] *= 40.0
    log = log_from_table(pa.table(messy), "messy")
    diagnosis = diagnose_log(log, case.stated)
    assert named(diagnosis) == {(hidden.cause, hidden.joint) for hidden in case.hidden}
    assert {"data.glitch", "data.duplicate"} <= {fault.kind for fault in log.faults}
    assert len(diagnosis.gap.motion.clock.gaps) == 1


@pytest.mark.deep
@pytest.mark.parametrize("seed", [1, 2])
def test_a_clean_log_has_no_finding(seed: int) -> None:
    setting = Setting(seconds=40.0, rate=250.0, off=0.03 * (seed % 2), noise=(0.05, 0.2)[seed // 2])
    diagnosis = diagnosed(make_case(60 + seed, setting, (), 1.0))
    assert diagnosis.findings == ()
    assert diagnosis.verdict is Verdict.CONSISTENT


@pytest.mark.deep
def test_what_is_no_cause_ends_as_unexplained() -> None:
    case = make_case(23, SHORT, (), 1.0)
    rng = np.random.default_rng(1)
    wander = np.interp(case.log["time"], np.linspace(0.0, 40.0, 30), rng.normal(size=30))
    case.log["effort.elbow_joint"] += 6.0 * wander
    diagnosis = diagnosed(case)
    assert diagnosis.verdict is Verdict.UNEXPLAINED
    assert {entry.joint for entry in diagnosis.remaining} == {"elbow_joint"}


@pytest.mark.deep
def test_play_is_no_delay() -> None:
    setting = Setting("ur5", rate=500.0, noise=0.1, encoder=2.0 * np.pi / 2**17, quantity="current")
    case = make_case(1009, setting, (draw_of("drive.backlash"),), SEVERITY["medium"])
    assert named(diagnosed(case)) == {("drive.backlash", "wrist_2_joint")}


@pytest.mark.deep
def test_play_of_a_sliding_table_is_found_with_its_size() -> None:
    case = make_case(12, Setting("machine_table", seconds=40.0, noise=0.1), (draw_of("drive.backlash"),), 2.0)
    (hidden,) = case.hidden
    (finding,) = diagnosed(case).findings
    assert (finding.cause, finding.joint) == ("drive.backlash", "axis")
    assert finding.parameters[0].value == pytest.approx(hidden.strength, rel=0.05)


@pytest.mark.deep
def test_a_landing_is_no_effort_that_comes_early(monkeypatch: pytest.MonkeyPatch) -> None:
    case = draw_case(540012).case()  # play, and behind it a give that hardly shows
    assert named(diagnosed(case)) == {("drive.backlash", "axis")}
    # Either of two refusals keeps it away: it comes early beside play, and friction knows nothing of it.
    monkeypatch.setattr(refusal, "_torn", lambda model: [])
    assert named(diagnosed(case)) == {("drive.backlash", "axis")}


@pytest.mark.deep
def test_what_links_that_are_off_leave_is_no_other_half_of_an_asymmetry() -> None:
    assert named(diagnosed(draw_case(820025).case())) == {("friction.asymmetry", "wrist_3_joint")}


@pytest.mark.deep
def test_play_behind_a_payload_is_drawn_with_it(monkeypatch: pytest.MonkeyPatch) -> None:
    case = draw_case(540002).case()  # a payload that weighs most of what the wrist's play lets go
    loose = ("drive.backlash", "wrist_2_joint")
    assert loose in named(diagnosed(case))
    monkeypatch.setattr(as_known, "WEIGHED", np.inf)
    assert loose not in named(diagnosed(case))


@pytest.mark.deep
def test_a_drive_that_others_could_stand_in_for_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    """All other drives 1 % off did as well on motion not fitted."""
    case = draw_case(740096).case()
    constant = ("drive.torque_constant", "joint3")
    (strength,) = (one.strength for one in case.hidden if (one.cause, one.joint) == constant)
    findings = {(one.cause, one.joint): one.parameters[0].value for one in diagnosed(case).findings}
    assert findings.keys() == {(one.cause, one.joint) for one in case.hidden}
    assert abs(findings[constant] - 1.0) == pytest.approx(strength, rel=0.1)
    monkeypatch.setattr(refusal, "relief", lambda model, without: 0.0)
    assert constant not in named(diagnosed(case))


@pytest.mark.deep
def test_a_play_of_a_third_of_a_millimetre_is_found() -> None:
    setting = Setting("linear_axis", seconds=40.0, rate=500.0, noise=0.05, off=0.03)
    case = make_case(4, setting, (draw_of("drive.backlash"),), SEVERITY["medium"])
    (hidden,) = case.hidden
    (finding,) = diagnosed(case).findings
    assert (finding.cause, finding.joint) == ("drive.backlash", "axis")
    assert finding.parameters[0].value == pytest.approx(hidden.strength, rel=0.05)
    assert hidden.strength < 0.34e-3


@pytest.mark.deep
@pytest.mark.parametrize(("seed", "grows"), [(20, {"difference"}), (24, {"head", "rod"})])
def test_seals_under_pressure_are_named_on_a_cylinder(seed: int, grows: set[str]) -> None:
    setting = Setting("hydraulic_cylinder", seconds=14.0, rate=250.0, noise=0.1)
    case = make_case(seed, setting, (draw_of("hydraulic.pressure"),), SEVERITY["large"])
    (finding,) = diagnosed(case).findings
    assert (finding.cause, finding.joint) == ("hydraulic.pressure", "piston")
    hidden = case.machine.joint("piston").pressure_friction.model_dump()
    assert {value.name for value in finding.parameters} == grows
    for value in finding.parameters:
        assert value.value == pytest.approx(hidden[value.name], rel=0.1)


def test_an_alternative_is_a_hit_and_no_false_alarm() -> None:
    arm = Finding("body.link_inertia", None, 0.5, ("drive.rotor_inertia",))
    told = Outcome((("drive.rotor_inertia", "elbow"),), (arm,), "ambiguous", 1.0, 1.0)
    assert told.hit
    assert told.false_alarms == ()
    assert not told.exact
    elsewhere = Finding("friction.load", "wrist", 0.5, ("drive.rotor_inertia",))
    wrong = Outcome((("drive.rotor_inertia", "elbow"),), (elsewhere,), "ambiguous", 1.0, 1.0)
    assert not wrong.hit
    assert wrong.false_alarms == (elsewhere,)


def test_what_no_cause_is_must_be_left_open() -> None:
    hum = (("outside.hum", "elbow"),)
    assert Outcome((), (), "unexplained", None, 1.0, outside=hum).exact
    assert not Outcome((), (), "explained", None, 1.0, outside=hum).exact


@pytest.mark.parametrize(
    ("cause", "joint", "exact"),
    [("body.spring", "elbow", True), ("body.spring", "wrist", False), ("hum", "elbow", False)],
)
def test_a_stop_told_as_the_spring_that_it_is_by_definition_is_right(cause: str, joint: str, *, exact: bool) -> None:
    stop = (("outside.soft_stop", "elbow"),)
    told = Outcome((), (Finding(cause, joint, 0.9),), "explained", None, 1.0, outside=stop)
    assert told.exact is exact
    assert bool(told.false_alarms) is not exact
    # Left open it is right too; a tone that is told as a spring never is.
    assert Outcome((), (), "unexplained", None, 1.0, outside=stop).exact
    tone = Outcome((), told.found, "explained", None, 1.0, outside=(("outside.hum", "elbow"),))
    assert not tone.exact
    assert tone.false_alarms


def test_what_is_left_open_though_nothing_is_outside_all_causes_was_so_in_vain() -> None:
    hum = (("outside.hum", "elbow"),)
    right = Outcome((), (), "unexplained", None, 1.0, outside=hum)
    wrong = Outcome((), (), "unexplained", None, 1.0)
    clean = Outcome((), (), "consistent", None, 1.0)
    assert score([right, wrong, clean]).open_in_vain == 0.5
    assert np.isnan(score([right]).open_in_vain)


def test_what_is_too_faint_is_asked_of_no_tool_and_held_against_none() -> None:
    found = (Finding("drive.elasticity", "elbow", 0.9), Finding("friction.load", "elbow", 0.9))
    seen = Outcome((("friction.load", "elbow"),), found, "explained", 1.0, 1.0, faint=(("drive.elasticity", "elbow"),))
    assert seen.exact
    assert seen.false_alarms == ()
    missed = Outcome((), (), "consistent", None, 1.0, faint=(("drive.elasticity", "elbow"),))
    assert missed.exact
    assert missed.hit


@pytest.mark.parametrize(("severity", "asked"), [(0.8, False), (3.0, True)])
def test_a_value_that_is_off_no_more_than_the_others_is_asked_of_no_tool(severity: float, asked: bool) -> None:
    # 3 % off as everything, against several times that.
    setting = Setting(seconds=12.0, rate=250.0, noise=0.05, off=0.03)
    case = make_case(3, setting, (draw_of("drive.torque_constant"),), severity)
    (hidden,) = case.hidden
    assert hidden.severity > FAINT
    assert (hidden.strength > 0.09) == asked
    assert hidden.faint != asked
    (exactly,) = make_case(3, replace(setting, off=0.0), (draw_of("drive.torque_constant"),), severity).hidden
    assert not exactly.faint


def test_a_payload_and_its_own_link_are_not_both_hidden() -> None:
    draws = (draw_of("body.link_inertia"), draw_of("body.payload"))
    for seed in range(2):
        machine = make_case(seed, Setting(seconds=12.0, rate=250.0), draws, 1.0).machine
        assert machine.table.payload is not None
        assert "wrist_3_joint" not in machine.table.link_scale


def test_of_several_causes_each_counts_once_as_named_whether_all_were_found_or_not() -> None:
    hidden = (("friction.load", "elbow"), ("drive.offset", "wrist"))
    half = Outcome(hidden, (Finding("friction.load", "elbow", 0.9),), "explained", 1.0, 1.0)
    clean = Outcome((), (), "consistent", None, 1.0)
    both = score([half, clean])
    assert both.named == 0.5
    assert both.hit == 0.5
    assert np.isnan(score([clean]).named)


def test_a_machine_that_its_controller_cannot_hold_is_made_again_with_half(monkeypatch: pytest.MonkeyPatch) -> None:
    asked, limit, kept = [], [0.9], cases._made

    def made(seed: int, setting: Setting, draws: tuple[Draw, ...], severity: float) -> Case:
        asked.append(severity)
        if severity > limit[0]:
            raise SimulationError("the run went out of bounds")
        return kept(seed, setting, draws, severity)

    monkeypatch.setattr(cases, "_made", made)
    short = Setting(robot="linear_axis", seconds=5.0, rate=250.0)
    (hidden,) = make_case(3, short, (draw_of("drive.offset"),), 3.0).hidden
    assert asked == [3.0, 1.5, 0.75]
    assert hidden.severity == pytest.approx(0.75, rel=0.06)
    limit[0] = 0.0
    with pytest.raises(SimulationError):
        make_case(3, short, (draw_of("drive.offset"),), 3.0)
