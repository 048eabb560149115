"""Passes at constant speed accelerate at their ends only: there a rotor shows, in few rows."""

from __future__ import annotations

import pyarrow as pa
import pytest

from mjfriction.diagnose.causes.rotor_inertia import RotorInertia
from mjfriction.diagnose.diagnosis import diagnose_log
from mjfriction.identify.protocol import plan_passes
from mjfriction.plant.machine import simulate
from mjfriction.plant.sensors import Recorder
from mjfriction.record.log import Log
from mjfriction.record.readers.table import log_from_table
from mjfriction.robot.files import read_robot
from mjfriction.robot.robot import Robot

HEAVIER, NOISE = 1.7, 2.0  # times the stated rotor; N·m


def swept(stated: Robot) -> Log:
    real = stated
    for joint in stated.table.joint:
        sensors = {
            "effort_sensor": joint.effort_sensor.model_copy(update={"noise": NOISE}),
            "position_sensor": joint.position_sensor.model_copy(update={"resolution": 2e-5}),
        }
        real = real.with_joint(joint.model_copy(update=sensors))
    elbow = real.joint("elbow_joint")
    rotor = elbow.actuator.model_copy(update={"rotor_inertia": HEAVIER * elbow.actuator.rotor_inertia})
    real = real.with_joint(elbow.model_copy(update={"actuator": rotor}))
    passes = plan_passes(stated, ["shoulder_lift_joint", "elbow_joint"], count=4)
    return log_from_table(pa.table(simulate(real, passes.trajectory, recorder=Recorder(250.0), seed=1)), "passes")


@pytest.mark.deep
def test_a_rotor_is_told_from_the_ends_of_passes(monkeypatch: pytest.MonkeyPatch) -> None:
    stated = read_robot("ur5")
    log = swept(stated)
    (finding,) = diagnose_log(log, stated).findings
    assert (finding.cause, finding.joint) == ("drive.rotor_inertia", "elbow_joint")
    truth = HEAVIER * stated.joint("elbow_joint").actuator.rotor_inertia
    assert finding.parameters[0].value == pytest.approx(truth, rel=0.03)
    assert finding.gain.low > 0.0
    monkeypatch.setattr(RotorInertia, "brief_in_passes", False)
    assert all(other.cause != finding.cause for other in diagnose_log(log, stated).findings)
