"""Inertias that no body has stop MuJoCo's compiler: on bodies that do not move, and by rounding, they do no harm."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np
import pytest

from mjfriction.body.inverse import inverse_dynamics
from mjfriction.body.model import load_body
from mjfriction.errors import SimulationError
from mjfriction.sim.export import export_spec
from mjfriction.sim.spec import compiled, read_spec
from tests.hidden.machine import rigid_torque

LINK = '<link name="{name}"><inertial><origin xyz="{at}"/><mass value="{mass}"/><inertia {moments}/></inertial></link>'
SOUND = 'ixx="0.02" iyy="0.03" izz="0.02" ixy="0" ixz="0.004" iyz="0"'
# Of a plate that lies askew, as a file with six digits states it: its largest moment exceeds the sum of the others.
PLATE = 'ixx="0.019739" iyy="0.013653" izz="0.026607" ixy="0.002864" ixz="-0.000682" iyz="-0.007025"'
ROD = 'ixx="0.02" iyy="0.02" izz="-1e-20" ixy="0" ixz="0" iyz="0"'
IMPOSSIBLE = 'ixx="2.4e-8" iyy="2.8e-8" izz="3.8e-8" ixy="6.1e-8" ixz="1.2e-8" iyz="7.7e-9"'
JOINT = """<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/><origin xyz="0 0 0.3"/>
<axis xyz="0 1 0"/><limit lower="-2" upper="2" effort="9" velocity="9"/></joint>"""


def _arm(folder: Path, *, fore: str = ROD, held: str = "fixed") -> Path:
    links = [
        LINK.format(name="base", at="0 0 0", mass=5, moments=SOUND),
        LINK.format(name="antenna", at="0 0 0", mass=1e-6, moments=IMPOSSIBLE),
        LINK.format(name="upper", at="0.02 0 0.15", mass=2, moments=SOUND),
        LINK.format(name="fore", at="0 0 0.1", mass=1, moments=fore),
    ]
    joints = [
        JOINT.format(name="mast", kind=held, parent="base", child="antenna"),
        JOINT.format(name="shoulder", kind="revolute", parent="base", child="upper"),
        JOINT.format(name="elbow", kind="revolute", parent="upper", child="fore"),
    ]
    path = folder / "arm.urdf"
    path.write_text(f'<robot name="arm">{"".join(links + joints)}</robot>')
    return path


@pytest.mark.parametrize("held", ["fixed", "revolute"])
@pytest.mark.parametrize("fore", [ROD, PLATE])
def test_on_bodies_that_do_not_move(held: str, fore: str, tmp_path: Path) -> None:
    # As of the antennas of TIAGo; or of a head whose joint is held while an arm is examined.
    path, joints = _arm(tmp_path, held=held, fore=fore), ("shoulder", "elbow")
    q, v, a = np.random.default_rng(3).normal(size=(3, 20, 2))
    theirs = rigid_torque(compiled(read_spec(path, joints)), q, v, a)
    np.testing.assert_allclose(inverse_dynamics(load_body(path, joints), q, v, a), theirs, rtol=1e-4, atol=1e-5)


def test_a_moving_body_with_one_is_refused(tmp_path: Path) -> None:
    with pytest.raises(SimulationError, match="antenna"):
        compiled(read_spec(_arm(tmp_path, held="revolute"), ("mast", "shoulder", "elbow")))


def test_what_is_exported_reads_back_however_flat_its_plates_are(tmp_path: Path) -> None:
    # A plate's largest moment is the sum of the other two, which six digits miss by one either way.
    rng = np.random.default_rng(3)
    for _ in range(12):
        turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
        first, second = rng.uniform(0.01, 0.03, 2)
        plate = turn @ np.diag([first, second, first + second]) @ turn.T
        entries = zip(
            ("ixx", "iyy", "izz", "ixy", "ixz", "iyz"), ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)), strict=True
        )
        moments = " ".join(f'{name}="{float(plate[place])!r}"' for name, place in entries)
        spec, _ = export_spec(read_spec(_arm(tmp_path, fore=moments), ("shoulder", "elbow")), {})
        spec.compile()
        again = mujoco.MjModel.from_xml_string(spec.to_xml())
        assert again.body("fore").inertia == pytest.approx(np.sort([first, second, first + second])[::-1], rel=1e-4)
