"""Links that weigh by their shapes are scaled and moved like any other."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from mjfriction.body.inverse import inverse_dynamics
from mjfriction.body.model import load_body
from mjfriction.robot.plain_model import in_plain_words
from mjfriction.sim.spec import compiled, read_spec
from tests.hidden.machine import rigid_torque

ARM = """<mujoco><default><default class="thick"><geom type="capsule" size="0.05" mass="4"/></default></default>
  <worldbody><body name="upper" childclass="thick"><joint name="shoulder" axis="0 1 0"/><geom fromto="0 0 0 0 0 0.4"/>
    <body name="fore" pos="0 0 0.4"><joint name="elbow" axis="0 1 0"/><geom fromto="0 0 0 0.1 0 0.3"/>
      <inertial pos="0 0 0.1" mass="1" diaginertia="0.01 0.01 0.01"/></body></body>
  </worldbody></mujoco>"""
JOINTS = ("shoulder", "elbow")


@pytest.mark.parametrize("change", [{"link_scale": {"elbow": 1.3}}, {"link_shift": {"elbow": (0.0, 0.01, 0.02)}}])
@pytest.mark.parametrize("by_shape", ["auto", "true"])
def test_both_engines_agree_on_them(change: dict[str, dict[str, object]], by_shape: str, tmp_path: Path) -> None:
    path = tmp_path / "arm.xml"
    path.write_text(ARM.replace("<mujoco>", f'<mujoco><compiler inertiafromgeom="{by_shape}"/>'))
    q, v, a = np.random.default_rng(3).normal(size=(3, 20, 2))
    mine = inverse_dynamics(load_body(path, JOINTS, text=in_plain_words(path), **change), q, v, a)  # type: ignore[arg-type]
    theirs = rigid_torque(compiled(read_spec(path, JOINTS, **change)), q, v, a)  # type: ignore[arg-type]
    np.testing.assert_allclose(mine, theirs, rtol=1e-9, atol=1e-9)
