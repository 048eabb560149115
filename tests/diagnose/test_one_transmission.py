"""A drive besides those that are stated: its rotor is none of theirs, and told with it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from mjfriction.diagnose.causes.cause import Cause
from mjfriction.diagnose.causes.coupling import SumDrive, SumRotor
from mjfriction.diagnose.diagnosis import diagnose_log
from mjfriction.diagnose.search import one_transmission
from mjfriction.record.readers import read_log
from mjfriction.robot.files import read_robot
from mjfriction.robot.robot import Robot
from tests.hidden.machine import UR5_COULOMB, UR5_JOINTS, UR5_VISCOUS, Instant, Machine, write_case

OWN, NEIGHBOUR = 4, 3
COULOMB, VISCOUS, INERTIA = 0.35 * UR5_COULOMB[OWN], 0.3 * UR5_VISCOUS[OWN], 0.05
STATED = 0.3  # kg·m², rotor of either joint


def turned(by: int) -> Callable[[Instant], np.ndarray]:
    """Return what a joint's effort is more by: a drive that turns with the sum of two, and its own rotor."""

    def takes(instant: Instant) -> np.ndarray:
        hard = np.gradient(instant.velocities, instant.time, axis=0)
        turn, spin = (each[:, OWN] + each[:, NEIGHBOUR] for each in (instant.velocities, hard))
        return COULOMB * np.sign(turn) + VISCOUS * turn + INERTIA * spin + STATED * hard[:, by]

    return takes


def with_rotors(robot: Robot) -> Robot:
    for joint in (OWN, NEIGHBOUR):
        table = robot.table.joint[joint]
        actuator = table.actuator.model_copy(update={"rotor_inertia": STATED / table.actuator.gear_ratio**2})
        robot = robot.with_joint(table.model_copy(update={"actuator": actuator}))
    return robot


@pytest.mark.deep
@pytest.mark.parametrize("forms", [SumDrive.fuller, (SumRotor,)])
def test_a_drive_that_was_not_stated_is_one_finding_with_its_rotor(
    forms: tuple[type[Cause], ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Fitted as one, or where the rotor counts as stated, gathered from what both rotors seem to be more by."""
    monkeypatch.setattr(SumDrive, "fuller", forms)
    machine = Machine(hidden={joint: turned(joint) for joint in (OWN, NEIGHBOUR)})
    path, stated = write_case(tmp_path, machine, seed=3, seconds=30.0)
    log, robot = read_log(path), with_rotors(read_robot(stated))
    diagnosis = diagnose_log(log, robot)
    (finding,) = diagnosis.findings
    assert finding.cause == "drive.coupling"
    assert finding.joint in (UR5_JOINTS[OWN], UR5_JOINTS[NEIGHBOUR])
    found = {fitted.name: fitted.value for fitted in finding.parameters}
    truth = {"coulomb": COULOMB, "viscous": VISCOUS, "inertia": INERTIA, "ratio": 1.0}
    assert found == pytest.approx(truth, rel=0.1)
    # All of the stated rotors is still theirs.
    for joint in (OWN, NEIGHBOUR):
        assert diagnosis.robot.table.joint[joint].actuator.reflected_inertia == pytest.approx(STATED, rel=0.05)

    monkeypatch.setattr(one_transmission, "AS_GEARED", 0.0)
    apart = {one.cause for one in diagnose_log(log, robot).findings}
    assert apart == {"drive.coupling"} | ({"drive.rotor_inertia"} if forms == (SumRotor,) else set())
