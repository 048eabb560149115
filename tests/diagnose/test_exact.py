"""Where all else is stated exactly, a link a few percent off is a finding; where it is not, that is refitted along."""

from __future__ import annotations

from pathlib import Path

import mujoco
import pytest

from mjfriction.diagnose import stated
from mjfriction.diagnose.diagnosis import diagnose_log
from mjfriction.diagnose.outcome import Diagnosis
from mjfriction.record.readers import read_log
from mjfriction.robot.files import read_robot
from tests.hidden.machine import Machine, write_case

SCALE = 1.06


def stouter(model: mujoco.MjModel) -> None:
    body = model.body("forearm_link").id
    model.body_mass[body] *= SCALE
    model.body_inertia[body] *= SCALE


def diagnosed(folder: Path, off: float) -> Diagnosis:
    log, robot = write_case(folder, Machine(change=stouter, noise=0.1), seed=5, off=off)
    return diagnose_log(read_log(log), read_robot(robot))


def test_a_link_six_percent_heavier_is_named_beside_friction_that_is_right(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    found = diagnosed(tmp_path / "exact", 0.0)
    assert [finding.cause for finding in found.findings] == ["body.link_inertia"]
    (scale,) = found.findings[0].parameters
    assert scale.name == "link_scale.elbow_joint"
    assert scale.low < SCALE < scale.high < SCALE + 0.01
    assert not [change for change in found.adjustments if change.what.startswith("link")]
    # As one of many that may be off it is refitted along.
    monkeypatch.setattr(stated, "held_links", lambda model, *_: model)
    assert diagnosed(tmp_path / "refitted", 0.0).findings == ()


def test_beside_friction_that_is_off_it_is_refitted_along(tmp_path: Path) -> None:
    found = diagnosed(tmp_path, 0.04)
    assert found.findings == ()
    assert [change for change in found.adjustments if change.what.startswith("link")]
