"""Steady tones are heard beside causes, and keep neither a cause from being found nor one from being told wrongly."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from mjfriction.diagnose.causes.cause import Site
from mjfriction.diagnose.causes.delay import JointDelay
from mjfriction.diagnose.causes.waves import Cogging
from mjfriction.diagnose.diagnosis import diagnose_log
from mjfriction.diagnose.hum import unheard_tones
from mjfriction.diagnose.model import Chosen, build_model
from mjfriction.diagnose.nuisance import make_nuisance
from mjfriction.diagnose.outcome import Diagnosis, Verdict
from mjfriction.identify.gap import Gap, measure_gap
from mjfriction.record.readers import read_log
from mjfriction.robot.files import read_robot
from tests.hidden.machine import Instant, Machine, write_case

ELBOW = 2
FREQUENCY = 4.74


def hum(instant: Instant) -> np.ndarray:
    return 6.0 * np.sin(2.0 * np.pi * FREQUENCY * instant.time)


def cogging(instant: Instant) -> np.ndarray:
    return 3.0 * np.cos(12.0 * instant.q)


def cogging_and_hum(instant: Instant) -> np.ndarray:
    return hum(instant) + cogging(instant)


def gap_of_machine(folder: Path, machine: Machine) -> Gap:
    log, robot = write_case(folder, machine, seed=1, seconds=30.0)
    return measure_gap(read_log(log), read_robot(robot))


def diagnosed(folder: Path, machine: Machine) -> Diagnosis:
    log, robot = write_case(folder, machine, seed=2, seconds=30.0)
    return diagnose_log(read_log(log), read_robot(robot))


def test_a_tone_is_heard_once_beside_a_cause_that_is_real_and_one_that_is_none(tmp_path: Path) -> None:
    gap = gap_of_machine(tmp_path, Machine(hidden={ELBOW: cogging_and_hum}))
    delay = Chosen(JointDelay(), Site(ELBOW))
    waves = Chosen(Cogging(), Site(ELBOW, shape=(12.0,)))
    for cause in (delay, waves):
        [(joint, tone)] = unheard_tones(build_model(gap, make_nuisance(gap), (cause,)))
        assert joint == ELBOW
        assert tone.frequency == pytest.approx(FREQUENCY, abs=2e-3)
    heard = build_model(gap, make_nuisance(gap, [(ELBOW, tone)]), (waves,))
    assert unheard_tones(heard) == []
    left = [gap.rms(heard.heldout_residual(tones=tones)[:, ELBOW], ELBOW) for tones in (False, True)]
    assert left[0] < 1.2 * gap.noise_floor[ELBOW]
    assert left[1] == pytest.approx(6.0 / np.sqrt(2.0), rel=0.05)


def test_waves_along_the_stroke_are_no_tone(tmp_path: Path) -> None:
    gap = gap_of_machine(tmp_path, Machine(hidden={ELBOW: cogging}))
    waves = Chosen(Cogging(), Site(ELBOW, shape=(12.0,)))
    assert unheard_tones(build_model(gap, make_nuisance(gap), (waves,))) == []
    assert unheard_tones(build_model(gap, make_nuisance(gap), ())) == []


def test_a_hum_is_left_open_and_named(tmp_path: Path) -> None:
    found = diagnosed(tmp_path, Machine(hidden={ELBOW: hum}))
    assert found.findings == ()
    assert found.verdict is Verdict.UNEXPLAINED
    assert "a steady tone of 4.74 Hz" in found.summary
    # No robot makes it: the error that is reported holds it still.
    elbow = next(error for error in found.joints if error.joint == "elbow_joint")
    assert elbow.rms_heldout_after == pytest.approx(6.0 / np.sqrt(2.0), rel=0.05)


def test_two_tones_at_one_joint_are_both_named(tmp_path: Path) -> None:
    second = 2.31
    machine = Machine(hidden={ELBOW: lambda i: hum(i) + 3.0 * np.cos(2.0 * np.pi * second * i.time)})
    found = diagnosed(tmp_path, machine)
    assert found.findings == ()
    assert [entry.covariate for entry in found.remaining] == ["steady tones of 4.74 and 2.31 Hz"]


def test_a_cause_under_a_louder_hum_is_found_and_alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    machine = Machine(hidden={ELBOW: lambda i: hum(i) + 0.13 * cogging(i)})
    found = diagnosed(tmp_path, machine)
    assert [(one.cause, one.joint) for one in found.findings] == [("drive.cogging", "elbow_joint")]
    assert found.verdict is Verdict.UNEXPLAINED
    assert [entry.covariate for entry in found.remaining] == ["a steady tone of 4.74 Hz"]
    monkeypatch.setattr("mjfriction.diagnose.compete.unheard_tones", lambda model: [])
    deaf = diagnosed(tmp_path, machine)
    assert [(one.cause, one.joint) for one in deaf.findings] != [("drive.cogging", "elbow_joint")]
