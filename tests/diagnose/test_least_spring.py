"""Hoses, cables and a base that is not quite level make a few percent of friction on any machine: no spring."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from mjfriction.diagnose.causes.spring import BentSpring, Spring
from mjfriction.diagnose.diagnosis import diagnose_log
from mjfriction.diagnose.tell.visible import visible_causes
from mjfriction.identify.measure import measure_gap
from mjfriction.record.log import Log
from mjfriction.record.readers import read_log
from mjfriction.robot.files import read_robot
from mjfriction.robot.robot import Robot
from tests.hidden.machine import UR5_COULOMB, Instant, Machine, write_case

PULLED, UNEVEN = 1, (0, 1, 2, 3)
SPRING = ("body.spring", "shoulder_lift_joint")


def uneven(joint: int, at: Instant) -> np.ndarray:
    return 0.018 * UR5_COULOMB[joint] * np.cos((5.0 + joint) * at.q + joint) * np.sign(at.v)


def pulled(share: float, folder: Path) -> tuple[Log, Robot]:
    """Return the log of a machine as uneven as real ones are, with a spring of a share of friction at its most."""

    def effect(joint: int, at: Instant) -> np.ndarray:
        stroke = at.q - np.mean(at.q)
        spring = share * UR5_COULOMB[joint] * stroke / np.max(np.abs(stroke)) if joint == PULLED else 0.0
        return uneven(joint, at) + spring

    hidden = {joint: lambda at, joint=joint: effect(joint, at) for joint in UNEVEN}
    log, robot = write_case(folder, Machine(noise=0.03, hidden=hidden), seed=21, seconds=30.0)
    return read_log(log), read_robot(robot)


def told(log: Log, robot: Robot) -> set[tuple[str, str | None]]:
    return {(finding.cause, finding.joint) for finding in diagnose_log(log, robot).findings}


@pytest.mark.deep
def test_a_spring_has_to_make_more_than_any_machine_has(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert told(*pulled(0.25, tmp_path / "a spring")) == {SPRING}
    hose = pulled(0.09, tmp_path / "a hose")
    assert told(*hose) == set()
    for cause in (Spring, BentSpring):
        monkeypatch.setattr(cause, "least_told", 0.0)
    assert told(*hose) == {SPRING}


def test_how_much_a_spring_would_have_to_make_is_said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    log, robot = pulled(0.0, tmp_path)

    def least() -> float:
        # Where gravity does not outweigh friction: beside much of it the share of the effort is what counts.
        shown = visible_causes(measure_gap(log, robot))
        return min(one.share for one in shown if (one.cause, one.joint) == ("body.spring", "shoulder_pan_joint"))

    said = least()
    for cause in (Spring, BentSpring):
        monkeypatch.setattr(cause, "least_told", 0.0)
    assert said > 1.5 * least()
