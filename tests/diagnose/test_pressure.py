"""Seals that press with what they hold: either chamber's pressure, or the difference of the two."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pyarrow as pa
import pytest

from mjfriction.diagnose.diagnosis import diagnose_log
from mjfriction.diagnose.fit import trial
from mjfriction.diagnose.tell.outcome import Diagnosis
from mjfriction.plant.machine import simulate
from mjfriction.plant.motions import excitation
from mjfriction.plant.sensors import Recorder
from mjfriction.record.readers.table import log_from_table
from mjfriction.robot.friction_tables import PressureFriction
from tests.diagnose.test_lone_axis import COULOMB, pendulum


def diagnosed(folder: Path, hidden: dict[str, float], noise: float, level: float = COULOMB) -> Diagnosis:
    stated = pendulum(folder, "stated", inertia=0.08, rotor=6e-5, coulomb=COULOMB, noise=noise)
    pressed = {"pressure_friction": PressureFriction(**hidden)}
    rubs = pendulum(folder, "machine", inertia=0.08, rotor=6e-5, coulomb=level, noise=noise)
    machine = rubs.with_joint(rubs.joint("swing").model_copy(update=pressed))
    motion = excitation(("swing",), np.zeros(1), np.full(1, 1.2), np.full(1, 4.0), 30.0, seed=3)
    # Either chamber is the higher one for half of the time.
    pressures = {
        "pressure_head.swing": 4e6 + 2e6 * np.sin(0.7 * motion.time),
        "pressure_rod.swing": 4e6 + 2e6 * np.sin(1.1 * motion.time),
    }
    columns = simulate(machine, replace(motion, ambient=pressures), recorder=Recorder(250.0), seed=1)
    return diagnose_log(log_from_table(pa.table(columns), "swing"), stated)


@pytest.mark.parametrize("hidden", [{"difference": 2e-7}, {"head": 1e-7, "rod": 2e-7}])
def test_which_pressure_seals_press_with_is_told(hidden: dict[str, float], tmp_path: Path) -> None:
    (finding,) = diagnosed(tmp_path, hidden, noise=0.1).findings
    assert finding.cause == "hydraulic.pressure"
    assert {value.name: value.value for value in finding.parameters} == pytest.approx(hidden, rel=0.05)


@pytest.mark.parametrize(("level", "off"), [(COULOMB - 0.6, False), (COULOMB + 1.2, True)])
def test_a_level_that_is_as_stated_under_some_pressure_of_the_log_is_not_off(
    level: float, *, off: bool, tmp_path: Path
) -> None:
    """The pressures' mean makes 0.6 N·m: with that, what is left without pressure is what is stated, or never is."""
    found = diagnosed(tmp_path, {"head": 5e-8, "rod": 1e-7}, noise=0.05, level=level)
    causes = {finding.cause for finding in found.findings}
    assert "hydraulic.pressure" in causes
    assert ("friction.coulomb_viscous" in causes) is off


@pytest.mark.deep
def test_little_is_told_on_a_lone_axis_that_leaves_its_sensors_noise(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Seals that make 3 % of the friction: an uneven machine would leave more beside them than the noise is."""
    (finding,) = diagnosed(tmp_path, {"head": 8e-9, "rod": 12e-9}, noise=0.03).findings
    assert finding.cause == "hydraulic.pressure"
    monkeypatch.setattr(trial, "left_of_friction", lambda model, rms, joint: rms / model.friction[joint])
    assert diagnosed(tmp_path, {"head": 8e-9, "rod": 12e-9}, noise=0.03).findings == ()
