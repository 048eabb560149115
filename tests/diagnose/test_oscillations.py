"""Oscillations are heard beside causes, and keep neither a cause from being found nor one from being told wrongly."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from mjfriction.diagnose.causes.cause import Site
from mjfriction.diagnose.causes.delay import JointDelay
from mjfriction.diagnose.causes.waves import Cogging
from mjfriction.diagnose.diagnosis import diagnose_log
from mjfriction.diagnose.fit.model import Chosen, build_model
from mjfriction.diagnose.fit.nuisance import make_nuisance
from mjfriction.diagnose.search import oscillations
from mjfriction.diagnose.search.oscillations import new_oscillations
from mjfriction.diagnose.tell.outcome import Diagnosis, Verdict
from mjfriction.diagnose.tell.verdict import beside_oscillations
from mjfriction.identify.colour import NOTHING
from mjfriction.identify.gap import Gap
from mjfriction.identify.measure import measure_gap
from mjfriction.identify.swing import Swing
from mjfriction.identify.tone import Tone
from mjfriction.record.readers import read_log
from mjfriction.robot.files import read_robot
from tests.hidden.machine import Effect, Instant, Machine, write_case

ELBOW = 2
FREQUENCY = 4.74


def hum(instant: Instant) -> np.ndarray:
    return 6.0 * np.sin(2.0 * np.pi * FREQUENCY * instant.time)


def cogging(instant: Instant) -> np.ndarray:
    return 3.0 * np.cos(12.0 * instant.q)


def sloshing(instant: Instant, moved: float = 0.0) -> np.ndarray:
    """A load that swings at 0.42 Hz, driven by the joint's acceleration; ``moved`` is by how much it does already."""
    omega = 2.0 * np.pi * 0.42

    def slope(t: float, state: np.ndarray) -> tuple[float, float]:
        pull = np.interp(t, instant.time, instant.a)
        return state[1], -pull - 0.05 * omega * state[1] - omega**2 * state[0]

    span = (instant.time[0], instant.time[-1])
    solved = solve_ivp(slope, span, (moved, 0.0), t_eval=instant.time, max_step=0.02, rtol=1e-6)
    return 5.0 * solved.y[0] / np.std(solved.y[0])


def cogging_and_hum(instant: Instant) -> np.ndarray:
    return hum(instant) + cogging(instant)


def gap_of_machine(folder: Path, machine: Machine) -> Gap:
    log, robot = write_case(folder, machine, seed=1, seconds=30.0)
    return measure_gap(read_log(log), read_robot(robot))


def diagnosed(folder: Path, machine: Machine) -> Diagnosis:
    log, robot = write_case(folder, machine, seed=2, seconds=30.0)
    return diagnose_log(read_log(log), read_robot(robot))


def test_what_hardly_swings_is_not_tuned(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    class TunedError(Exception):
        pass

    def tuned(*_: object, **__: object) -> None:
        raise TunedError

    def heard(effect: Effect) -> list[object]:
        gap = gap_of_machine(tmp_path / effect.__name__, Machine(hidden={ELBOW: effect}))
        return list(new_oscillations(build_model(gap, make_nuisance(gap), ())))

    monkeypatch.setattr(oscillations, "minimize", tuned)
    assert heard(cogging) == []
    with pytest.raises(TunedError):
        heard(sloshing)
    monkeypatch.setattr(oscillations, "UNTUNED", 0.0)
    with pytest.raises(TunedError):
        heard(cogging)


def test_a_tone_is_heard_once_beside_a_cause_that_is_real_and_one_that_is_none(tmp_path: Path) -> None:
    gap = gap_of_machine(tmp_path, Machine(hidden={ELBOW: cogging_and_hum}))
    delay = Chosen(JointDelay(), Site(ELBOW))
    waves = Chosen(Cogging(), Site(ELBOW, shape=(12.0,)))
    for cause in (delay, waves):
        [tone] = new_oscillations(build_model(gap, make_nuisance(gap), (cause,)))
        assert tone.joint == ELBOW
        assert tone.frequency == pytest.approx(FREQUENCY, abs=2e-3)
    heard = build_model(gap, make_nuisance(gap, [tone]), (waves,))
    assert new_oscillations(heard) == []
    left = [gap.rms(heard.heldout_residual(oscillations=heard_too)[:, ELBOW], ELBOW) for heard_too in (False, True)]
    assert left[0] < 1.2 * gap.noise_floor[ELBOW]
    assert left[1] == pytest.approx(6.0 / np.sqrt(2.0), rel=0.05)


def test_waves_along_the_stroke_are_no_tone(tmp_path: Path) -> None:
    gap = gap_of_machine(tmp_path, Machine(hidden={ELBOW: cogging}))
    waves = Chosen(Cogging(), Site(ELBOW, shape=(12.0,)))
    assert new_oscillations(build_model(gap, make_nuisance(gap), (waves,))) == []
    assert new_oscillations(build_model(gap, make_nuisance(gap), ())) == []


def test_a_hum_is_left_open_and_named(tmp_path: Path) -> None:
    found = diagnosed(tmp_path, Machine(hidden={ELBOW: hum}))
    assert found.findings == ()
    assert found.verdict is Verdict.UNEXPLAINED
    assert "a steady tone of 4.74 Hz" in found.summary
    # No robot makes it: the error that is reported holds it still.
    elbow = next(error for error in found.joints if error.joint == "elbow_joint")
    assert elbow.rms_heldout_after == pytest.approx(6.0 / np.sqrt(2.0), rel=0.05)


@pytest.mark.deep
def test_two_tones_at_one_joint_are_both_named(tmp_path: Path) -> None:
    second = 2.31
    machine = Machine(hidden={ELBOW: lambda i: hum(i) + 3.0 * np.cos(2.0 * np.pi * second * i.time)})
    found = diagnosed(tmp_path, machine)
    assert found.findings == ()
    assert [entry.covariate for entry in found.remaining] == ["a steady tone of 4.74 Hz and a steady tone of 2.31 Hz"]


@pytest.mark.deep
def test_a_cause_under_a_louder_hum_is_found_and_alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    machine = Machine(hidden={ELBOW: lambda i: hum(i) + 0.13 * cogging(i)})
    found = diagnosed(tmp_path, machine)
    assert [(one.cause, one.joint) for one in found.findings] == [("drive.cogging", "elbow_joint")]
    assert found.verdict is Verdict.UNEXPLAINED
    assert [entry.covariate for entry in found.remaining] == ["a steady tone of 4.74 Hz"]
    monkeypatch.setattr("mjfriction.diagnose.search.compete.new_oscillations", lambda model: [])
    deaf = diagnosed(tmp_path, machine)
    assert [(one.cause, one.joint) for one in deaf.findings] != [("drive.cogging", "elbow_joint")]


def test_what_is_left_beside_a_hum_is_known_as_unexplained(tmp_path: Path) -> None:
    def brake(instant: Instant) -> np.ndarray:
        return 4.0 * np.sin(2.0 * np.pi * 0.05 * instant.time**1.3) * np.tanh(instant.v / 0.01)

    for hidden, left in ((hum, False), (lambda i: hum(i) + brake(i), True)):
        gap = gap_of_machine(tmp_path, Machine(hidden={ELBOW: hidden}))
        model = build_model(gap, make_nuisance(gap, [Tone(ELBOW, FREQUENCY)]), ())
        assert (ELBOW in beside_oscillations(model, model.heldout_residual())) == left


def test_a_load_that_swings_is_left_open_and_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    machine = Machine(hidden={ELBOW: sloshing})
    found = diagnosed(tmp_path, machine)
    assert found.findings == ()
    assert found.verdict is Verdict.UNEXPLAINED
    [left] = found.remaining
    assert left.covariate.startswith("a load that swings at ")
    assert float(left.covariate.split()[-2]) == pytest.approx(0.42, rel=0.01)
    elbow = next(error for error in found.joints if error.joint == "elbow_joint")
    assert elbow.rms_heldout_after == pytest.approx(5.0, rel=0.1)
    monkeypatch.setattr("mjfriction.diagnose.search.oscillations._loudest_swing", lambda *_: None)
    assert [entry.covariate for entry in diagnosed(tmp_path, machine).remaining] == [NOTHING]


def test_a_load_that_swings_when_the_log_begins_is_one_load(tmp_path: Path) -> None:
    gap = gap_of_machine(tmp_path, Machine(hidden={ELBOW: lambda i: sloshing(i, moved=2.0)}))
    model = build_model(gap, make_nuisance(gap), ())
    [swing] = new_oscillations(model)
    assert isinstance(swing, Swing)
    assert swing.frequency == pytest.approx(0.42, rel=0.01)
    beside = build_model(gap, make_nuisance(gap, [swing]), ())
    assert new_oscillations(beside) == []
    assert gap.rms(beside.heldout_residual()[:, ELBOW], ELBOW) < 1.2 * gap.noise_floor[ELBOW]


@pytest.mark.deep
def test_a_cause_under_a_load_that_swings_is_found_and_alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    machine = Machine(hidden={ELBOW: lambda i: sloshing(i) + 0.2 * cogging(i)})
    found = diagnosed(tmp_path, machine)
    assert [(one.cause, one.joint) for one in found.findings] == [("drive.cogging", "elbow_joint")]
    monkeypatch.setattr("mjfriction.diagnose.search.oscillations._loudest_swing", lambda *_: None)
    deaf = diagnosed(tmp_path, machine)
    assert [(one.cause, one.joint) for one in deaf.findings] != [("drive.cogging", "elbow_joint")]


@pytest.mark.parametrize(
    ("hidden", "mistaken"),
    [
        (lambda i: 1.5 * i.a, True),  # a rotor's inertia
        (lambda i: 20.0 * i.q, False),  # a spring
        (lambda i: 60.0 * i.v * np.abs(i.v), False),
        (lambda i: np.interp(i.time - 0.2, i.time, i.rigid) - i.rigid, False),  # a delay
    ],
)
def test_what_a_cause_makes_is_no_load_that_swings(
    hidden: Effect, mistaken: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    gap = gap_of_machine(tmp_path, Machine(hidden={ELBOW: hidden}))
    model = build_model(gap, make_nuisance(gap), ())
    assert gap.rms(model.heldout_residual()[:, ELBOW], ELBOW) > 2.0 * gap.noise_floor[ELBOW]
    assert new_oscillations(model) == []
    if mistaken:
        monkeypatch.setattr("mjfriction.diagnose.search.oscillations.RESONANT", np.inf)
        assert new_oscillations(model) != []
