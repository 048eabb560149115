"""Friction that settles with running time, though a temperature was logged that goes another way."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from mjfriction.diagnose.causes import varying
from mjfriction.diagnose.causes.varying import WarmUpDrift
from mjfriction.diagnose.diagnosis import diagnose_log
from mjfriction.diagnose.search import compete
from mjfriction.diagnose.settle import stated
from mjfriction.record.readers import read_log
from mjfriction.robot.files import read_robot
from tests.hidden.machine import UR5_COULOMB, UR5_VISCOUS, Instant, Machine, write_case

ELBOW, TIME_CONSTANT = 2, 9.0


def settling(at: Instant) -> np.ndarray:
    return 0.8 * UR5_VISCOUS[ELBOW] * np.exp(-at.time / TIME_CONSTANT) * at.v


def test_it_settles_with_running_time(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # The sensor sits where the air from a fan goes.
    ambient = {"temperature.elbow_joint": lambda time: 24.0 + 3.0 * np.sin(0.2 * time)}
    log, robot = write_case(
        tmp_path, Machine(hidden={ELBOW: settling}, noise=0.1, ambient=ambient), seed=4, seconds=30.0
    )
    (found,) = diagnose_log(read_log(log), read_robot(robot)).findings
    assert (found.cause, found.joint) == ("friction.temperature", "elbow_joint")
    (constant,) = [value for value in found.parameters if value.name == "time_constant"]
    assert constant.low < TIME_CONSTANT < constant.high
    assert constant.high - constant.low < TIME_CONSTANT
    monkeypatch.setattr(WarmUpDrift, "sites", lambda *_: [])
    findings = diagnose_log(read_log(log), read_robot(robot)).findings
    assert "friction.temperature" not in {one.cause for one in findings}


@pytest.mark.deep
def test_a_sensor_of_whole_degrees_is_followed_all_the_same(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def warm(time: np.ndarray) -> np.ndarray:
        return 12.0 * (1.0 - np.exp(-time / 14.0))

    def warming(at: Instant) -> np.ndarray:
        return 0.3 * warm(at.time) * np.sign(at.v)

    ambient = {"temperature.elbow_joint": lambda time: np.round(24.0 + warm(time))}
    log, robot = write_case(
        tmp_path, Machine(hidden={ELBOW: warming}, noise=0.1, ambient=ambient), seed=4, seconds=30.0
    )

    def parameters() -> set[str]:
        (found,) = diagnose_log(read_log(log), read_robot(robot)).findings
        assert (found.cause, found.joint) == ("friction.temperature", "elbow_joint")
        return {value.name for value in found.parameters}

    assert "coulomb_per_kelvin" in parameters()
    monkeypatch.setattr(compete, "by_temperature", lambda model, _: model)
    assert "time_constant" in parameters()


@pytest.mark.deep
def test_what_is_over_in_two_seconds_is_no_warm_up(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def at_first(at: Instant) -> np.ndarray:
        return 1.6 * UR5_VISCOUS[ELBOW] * np.exp(-at.time / 1.8) * at.v

    log, robot = write_case(tmp_path, Machine(hidden={ELBOW: at_first}, noise=0.1), seed=4, seconds=9.0)

    def told() -> set[str]:
        return {one.cause for one in diagnose_log(read_log(log), read_robot(robot)).findings}

    assert "friction.temperature" not in told()
    monkeypatch.setattr(varying, "FASTEST", 0.5)
    assert "friction.temperature" in told()


@pytest.mark.deep
def test_a_warm_up_of_a_twelfth_of_the_log_is_one(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    seconds, tau = 60.0, 5.0

    def settling_fast(at: Instant) -> np.ndarray:
        return np.exp(-at.time / tau) * (0.5 * UR5_COULOMB[ELBOW] * np.sign(at.v) + 0.8 * UR5_VISCOUS[ELBOW] * at.v)

    log, robot = write_case(tmp_path, Machine(hidden={ELBOW: settling_fast}, noise=0.1), seed=4, seconds=seconds)

    def told() -> list[tuple[str, str | None]]:
        return [(one.cause, one.joint) for one in diagnose_log(read_log(log), read_robot(robot)).findings]

    assert told() == [("friction.temperature", "elbow_joint")]
    monkeypatch.setattr(varying, "FASTEST", 0.1 * seconds)
    assert told() != [("friction.temperature", "elbow_joint")]


@pytest.mark.deep
def test_damping_that_is_as_stated_when_warm_has_no_rival(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A lubricant's viscosity falls exponentially; what is stated holds at one temperature on the way.  A bend of the
    curve over speed would do as well as the level that is off at room temperature, with one freedom less.
    """

    def warm(time: np.ndarray) -> np.ndarray:
        return 20.0 * (1.0 - np.exp(-time / 20.0))

    def thinning(at: Instant) -> np.ndarray:
        return (np.exp(-0.05 * (warm(at.time) - 12.0)) - 1.0) * UR5_VISCOUS[ELBOW] * at.v

    ambient = {"temperature.elbow_joint": lambda time: 25.0 + warm(time)}
    machine = Machine(hidden={ELBOW: thinning}, noise=0.1, ambient=ambient)
    log, robot = write_case(tmp_path, machine, seed=4, seconds=40.0, off=0.03)

    rivals = []
    simpler = stated._simpler
    monkeypatch.setattr(stated, "_simpler", lambda *given: rivals.append(given[1].chosen.site.joint) or simpler(*given))
    (found,) = diagnose_log(read_log(log), read_robot(robot)).findings
    assert (found.cause, found.joint) == ("friction.temperature", "elbow_joint")
    assert ELBOW not in rivals
    monkeypatch.setattr(stated, "_of_another_moment", lambda *_: False)
    assert len(diagnose_log(read_log(log), read_robot(robot)).findings) > 1
    assert ELBOW in rivals
