"""Effects hidden in the efforts of a real machine are named beside all that it has of its own."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from mjfriction.diagnose.diagnosis import diagnose_log
from mjfriction.diagnose.tell.outcome import Diagnosis, Verdict
from mjfriction.record.log import Floats, Log
from mjfriction.record.readers import read_log
from mjfriction.robot.files import read_robot

LEVEL = 10.0  # N, half of the axis' Coulomb friction
Effect = Callable[[Floats, Floats, Floats], Floats]
"""What is added to the effort (n,), by time, position and velocity."""

EFFECTS: dict[str, Effect] = {
    "drive.cogging": lambda time, place, speed: LEVEL * np.sin(2.0 * np.pi * 9.3 * place / np.ptp(place)),
    "friction.position": lambda time, place, speed: (
        LEVEL * np.sign(speed) * np.sin(2.0 * np.pi * 4.3 * place / np.ptp(place))
    ),
    "event.change": lambda time, place, speed: LEVEL * np.sign(speed) * (time > 0.45 * time[-1]),
    "body.spring": lambda time, place, speed: LEVEL * (place - np.mean(place)) / np.std(place),
    "friction.coulomb_viscous": lambda time, place, speed: LEVEL * np.sign(speed),
}


@pytest.fixture(scope="module")
def axis(data: Path) -> tuple[Log, Diagnosis]:
    log = read_log(data / "emps/estimation.parquet")
    return log, diagnose_log(log, read_robot(data / "emps/robot.toml"))


def test_the_extended_robot_has_nothing_left_to_be_told(axis: tuple[Log, Diagnosis]) -> None:
    log, found = axis
    again = diagnose_log(log, found.robot)
    assert (again.verdict, again.findings) == (Verdict.CONSISTENT, ())


@pytest.mark.parametrize("cause", EFFECTS)
def test_what_is_hidden_is_named_and_nothing_else(cause: str, axis: tuple[Log, Diagnosis]) -> None:
    log, found = axis
    motion = found.gap.motion
    speed = np.interp(log.time, motion.time, motion.velocity[:, 0])
    added = EFFECTS[cause](log.time - log.time[0], log.columns["position.axis"], speed)
    changed = replace(log, columns={**log.columns, "effort.axis": log.columns["effort.axis"] + added})
    (finding,) = diagnose_log(changed, found.robot).findings
    assert (finding.cause, finding.joint) == (cause, "axis")
    assert finding.gain.reduction > 0.5
