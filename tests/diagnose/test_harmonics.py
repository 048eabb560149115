"""Waves along a stroke are recovered from a machine's own log, each as the one that it is."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pyarrow as pa
import pytest

from mjfriction.control.servo import Control
from mjfriction.diagnose import diagnosis
from mjfriction.diagnose.causes.friction_spot import FrictionSpot
from mjfriction.diagnose.causes.waves import PositionFriction
from mjfriction.diagnose.diagnosis import diagnose_log
from mjfriction.diagnose.search import compete
from mjfriction.diagnose.settle import stated
from mjfriction.diagnose.tell.outcome import Diagnosis
from mjfriction.identify.protocol import plan_excitation
from mjfriction.plant.machine import simulate
from mjfriction.plant.sensors import Recorder
from mjfriction.record.readers import read_log
from mjfriction.record.readers.table import log_from_table
from mjfriction.robot.files import read_robot
from tests.hidden.machine import Machine, record, write_case


@pytest.mark.deep
def test_a_wave_of_little_more_than_a_period_is_one_wave(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def found(wavenumber: float) -> Diagnosis:
        machine = Machine(noise=0.05, hidden={2: lambda own: 4.0 * np.cos(wavenumber * own.q)})
        log, robot = write_case(tmp_path, machine, seed=21)
        return diagnose_log(read_log(log), read_robot(robot))

    stroke = float(np.ptp(record(Machine(), 21)["position.elbow_joint"]))
    wavenumber = 1.35 * 2.0 * np.pi / stroke
    (finding,) = found(wavenumber).findings
    assert (finding.cause, finding.joint) == ("drive.cogging", "elbow_joint")
    assert finding.parameters[0].value ** 2 + finding.parameters[1].value ** 2 == pytest.approx(16.0, rel=0.05)
    monkeypatch.setattr("mjfriction.identify.stroke_waves.FEWEST_WAVES", 1.5)
    assert [own.cause for own in found(wavenumber).findings] != ["drive.cogging"]


@pytest.mark.deep
def test_friction_that_rises_along_the_stroke_is_half_a_wave(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    machine, lift = Machine(noise=0.2, hidden={1: lambda own: 3.0 * own.q * np.sign(own.v)}), "shoulder_lift_joint"
    log, robot = write_case(tmp_path, machine, seed=4)

    def found() -> list[np.ndarray]:
        findings = diagnose_log(read_log(log), read_robot(robot)).findings
        assert {(finding.cause, finding.joint) for finding in findings} == {("friction.position", lift)}
        return [np.array([own.value for own in finding.parameters if own.unit == "N·m"]) for finding in findings]

    position = read_log(log).columns[f"position.{lift}"]
    (amplitudes,) = found()
    assert np.linalg.norm(amplitudes) < 1.5 * np.max(np.abs(3.0 * position))
    # Waves that are too short for it cancel each other, where two may be nearly the same, and neither a spot nor a
    # course takes their place.
    for place in (compete, stated):
        monkeypatch.setattr(place, "as_courses", lambda model: model)
    waves = tuple(cause for cause in diagnosis.STRUCTURAL if not isinstance(cause, FrictionSpot))
    monkeypatch.setattr(diagnosis, "STRUCTURAL", waves)
    monkeypatch.setattr("mjfriction.identify.stroke_waves.FEWEST_TURNING", 1.2)
    monkeypatch.setattr(PositionFriction, "apart", lambda *_: True)
    assert max(np.linalg.norm(own) for own in found()) > 10.0 * np.max(np.abs(3.0 * position))


@pytest.mark.deep
def test_the_tables_cogging_is_recovered() -> None:
    table = read_robot("machine_table")
    stated = table.with_joint(table.table.joint[0].model_copy(update={"cogging": ()}))
    motion = plan_excitation(table, 60.0).trajectory
    columns = simulate(table, motion, recorder=Recorder(1000.0), control=Control(bandwidth=15.0), seed=1)
    found = diagnose_log(log_from_table(pa.table(columns), "log"), stated).findings
    assert {finding.cause for finding in found} == {"drive.cogging"}
    fitted = [{p.name: p for p in finding.parameters} for finding in found]
    # The second and third, 1.5 and 0.5 N, are no more than the waves of an uneven machine.
    for wave in table.table.joint[0].cogging[:1]:
        values = min(fitted, key=lambda own: abs(own["wavenumber"].value - wave.wavenumber))
        size = np.hypot(wave.cosine, wave.sine)
        assert abs(values["wavenumber"].value - wave.wavenumber) < 0.2
        assert abs(values["cosine"].value - wave.cosine) < 0.02 * size
        assert abs(values["sine"].value - wave.sine) < 0.02 * size
