"""A link whose moments of inertia are off, and its mass is not: a part that turns was modelled as a point, or a tensor
typed wrong.
"""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np
import pytest

from mjfriction.body.inverse import inverse_dynamics
from mjfriction.body.regressor import link_change_torques
from mjfriction.diagnose.causes.links import LinkMoments
from mjfriction.diagnose.diagnosis import diagnose_log
from mjfriction.diagnose.tell.outcome import Diagnosis
from mjfriction.record.readers import read_log
from mjfriction.robot.body_tables import Payload
from mjfriction.robot.files import read_robot
from mjfriction.robot.links import scaled_link, shifted_link, with_moments
from mjfriction.robot.robot import Robot
from tests.deep import deep
from tests.hidden.machine import Machine, write_case

LINK, FACTOR = "wrist_1_joint", 40.0


def test_the_column_is_what_a_factor_on_the_moments_adds() -> None:
    """On a link that is scaled and shifted too, and beside a payload on another."""
    robot = read_robot("ur5")
    payload = Payload(mass=1.0, com=(0.0, 0.02, 0.05), parent="wrist_3_joint")
    robot = Robot(robot.table.model_copy(update={"payload": payload}), robot.folder)
    robot = shifted_link(scaled_link(robot, LINK, 1.2), LINK, (0.01, 0.0, -0.02))
    body, rng = robot.body(), np.random.default_rng(1)
    q, v, a = rng.uniform(-1.5, 1.5, (3, 40, 6))
    columns = link_change_torques(body, q, v, a)[:, :, body.links.index(LINK), 4]
    added = inverse_dynamics(with_moments(robot, LINK, 3.0).body(), q, v, a) - inverse_dynamics(body, q, v, a)
    np.testing.assert_allclose(added, 2.0 * columns, atol=1e-12)


def turning(model: mujoco.MjModel) -> None:
    model.body_inertia[model.body("wrist_1_link").id] *= FACTOR


def diagnosed(folder: Path, off: float = 0.0) -> Diagnosis:
    log, robot = write_case(folder, Machine(change=turning, noise=0.03), seed=5, seconds=40.0, off=off)
    return diagnose_log(read_log(log), read_robot(robot))


@pytest.mark.deep
@pytest.mark.parametrize("off", [deep(0.0), 0.02])
def test_moments_that_are_off_are_told_as_the_links(
    off: float, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    found = diagnosed(tmp_path, off)
    (finding,) = found.findings
    assert (finding.cause, finding.joint) == ("body.link_inertia", None)
    (moments,) = finding.parameters
    assert moments.name == f"link_moments.{LINK}"
    assert moments.low < FACTOR < moments.high
    assert moments.value == pytest.approx(FACTOR, rel=0.05)
    monkeypatch.setattr(LinkMoments, "sites", lambda *_: [])
    assert len(diagnosed(tmp_path, off).findings) != 1
