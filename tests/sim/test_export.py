"""Friction as stock MuJoCo carries it."""

from __future__ import annotations

import json
import subprocess
import sys

import mujoco
import numpy as np
import pytest

from mjfriction.errors import SimulationError
from mjfriction.laws.ambient import PRESSURE_HEAD
from mjfriction.laws.catalog import LAWS
from mjfriction.laws.friction import friction
from mjfriction.sim.attach import attach
from mjfriction.sim.callback import friction_active
from mjfriction.sim.export import as_native, export_spec, probing_motion
from tests.cli.test_cli import mjfriction
from tests.contract.draws import named
from tests.sim.models import LUGRE, PENDULUM, ROTOR, lugre, spec

PROBE = probing_motion(2.0, 5.0)
SLIP = {"viscous": 0.5, "stiffness": [4e3, 2e3, 5e2], "level": [1.0, 2.0, 1.5]}


def swing(model: mujoco.MjModel, h: float) -> np.ndarray:
    model.opt.timestep = h
    data = mujoco.MjData(model)
    out = []
    for k in range(round(0.8 / h)):
        data.ctrl[0] = 6.0 * np.sin(15.0 * k * h) + 2.0 * np.sin(4.0 * k * h)
        mujoco.mj_step(model, data)
        out.append(float(data.qpos[0]))
    return np.array(out)


def test_what_is_exact_is_said_to_be() -> None:
    exact = {
        "coulomb": {"coulomb": 2.0},
        "coulomb_viscous": {"coulomb": 2.0, "viscous": 0.3},
        "quadratic_viscous": {"coulomb": 2.0, "viscous": 0.3, "quadratic": 0.1},
        "lugre": LUGRE,
        "maxwell_slip": SLIP,
    }
    for name, values in exact.items():
        native, same = as_native([friction(name, values, gear_ratio=3.0)], PROBE, 2.0)
        assert same, name
        assert any(native.damping) or native.frictionloss
        _, report = export_spec(spec(ROTOR), {"rotor": [friction(name, values)]})
        assert report[0].error < 1e-9 * max(1.0, report[0].size)
    bent = {**exact["quadratic_viscous"], "quadratic": -0.01}
    for name, values in (("lugre", {**LUGRE, "stribeck_exponent": 1.0}), ("quadratic_viscous", bent)):
        assert not as_native([friction(name, values)], PROBE, 2.0)[1]


@pytest.mark.parametrize("name", [name for name, law in LAWS.items() if PRESSURE_HEAD not in law.reads])
def test_every_law_is_carried_with_its_error_told(name: str) -> None:
    made, (report,) = export_spec(spec(PENDULUM), {"swing": [friction(name, named(LAWS[name], 2))]})
    made.compile()
    assert np.isfinite(report.error)
    # Stock MuJoCo has nothing with two directions: half of the difference between them stays.
    assert report.error <= (0.5 if name == "asymmetric" else 0.25) * report.size
    assert report.exact == (report.error < 1e-9 * report.size)
    assert report.unit == "N·m"


def test_a_slides_error_is_in_newtons() -> None:
    made = spec('<mujoco><worldbody><body><joint name="way" type="slide"/><geom size="1"/></body></worldbody></mujoco>')
    _, (report,) = export_spec(made, {"way": [friction("coulomb", {"coulomb": 2.0})]})
    assert report.unit == "N"


def test_yielding_tendons_are_the_maxwell_slip_law() -> None:
    with friction_active():
        ours = swing(attach(spec(ROTOR), {"rotor": friction("maxwell_slip", SLIP)}), 1e-4)
    made, report = export_spec(spec(ROTOR), {"rotor": [friction("maxwell_slip", SLIP)]})
    assert report[0].exact
    native = swing(made.compile(), 1e-4)
    assert np.max(np.abs(native - ours)) < 0.01 * np.ptp(ours)
    bare = spec(ROTOR)
    bare.joint("rotor").damping[0] = SLIP["viscous"]
    assert np.max(np.abs(swing(bare.compile(), 1e-4) - ours)) > 0.3 * np.ptp(ours)


def test_an_unknown_joint_is_named() -> None:
    with pytest.raises(SimulationError, match="joint 'elbow' is not in the model"):
        export_spec(spec(ROTOR), {"elbow": [lugre()]})


def test_the_file_runs_in_a_process_that_has_no_mjfriction(tmp_path) -> None:
    (tmp_path / "arm.xml").write_text(ROTOR)
    slip = "{ viscous = 0.5, stiffness = [4e3, 2e3, 5e2], level = [1.0, 2.0, 1.5] }"
    fall = "{ coulomb = 0.5, static = 0.8, stribeck_velocity = 0.1, stribeck_exponent = 2.0, viscous = 0.0 }"
    (tmp_path / "robot.toml").write_text(
        'name = "one"\nmodel = "arm.xml"\n[[joint]]\nname = "rotor"\n'
        f'friction = [{{ law = "maxwell_slip", parameters = {slip} }}, {{ law = "stribeck", parameters = {fall} }}]\n'
    )
    done = mjfriction("export", "--robot", tmp_path / "robot.toml", "--out", tmp_path / "plain.xml", "--json")
    assert done.returncode == 0, done.stderr
    (joint,) = json.loads(done.stdout)["joints"]
    assert not joint["exact"]
    code = (
        "import mujoco, sys; m = mujoco.MjModel.from_xml_path(sys.argv[1]); d = mujoco.MjData(m); d.ctrl[0] = 12.0\n"
        "mujoco.mj_step(m, d, nstep=500); assert not any('mjfriction' in name for name in sys.modules)\n"
        "print(float(d.qvel[0]))"
    )
    out = subprocess.run(
        [sys.executable, "-c", code, str(tmp_path / "plain.xml")], capture_output=True, text=True, check=True
    )
    assert 0.0 < float(out.stdout) < 12.0 * 0.5 / 0.01 * 0.5  # far below what it would reach without friction
    assert sorted(path.name for path in tmp_path.iterdir()) == ["arm.xml", "plain.xml", "robot.toml"]


def test_a_model_with_meshes_is_exported_elsewhere(tmp_path) -> None:
    corners = [(0, 0, 0), (0.1, 0, 0), (0, 0.1, 0), (0, 0, 0.1)]
    (tmp_path / "shapes").mkdir()
    faces = ("1 3 2", "1 2 4", "2 3 4", "3 1 4")
    (tmp_path / "shapes" / "tip.obj").write_text(
        "".join(f"v {x} {y} {z}\n" for x, y, z in corners) + "".join(f"f {face}\n" for face in faces)
    )
    (tmp_path / "arm.xml").write_text(
        '<mujoco><compiler meshdir="shapes"/><asset><mesh name="tip" file="tip.obj"/></asset><worldbody><body>'
        '<joint name="rotor" axis="0 0 1"/><geom type="mesh" mesh="tip"/></body></worldbody></mujoco>'
    )
    (tmp_path / "robot.toml").write_text(
        'name = "one"\nmodel = "arm.xml"\n[[joint]]\nname = "rotor"\n'
        'friction = { law = "coulomb", parameters = { coulomb = 1.0 } }\n'
    )
    (tmp_path / "out").mkdir()
    done = mjfriction("export", "--robot", tmp_path / "robot.toml", "--out", tmp_path / "out" / "plain.xml")
    assert done.returncode == 0, done.stderr
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "out" / "plain.xml"))
    assert (model.nmesh, model.dof_frictionloss[0]) == (1, 1.0)


def test_what_the_file_does_not_hold_is_said(tmp_path) -> None:
    (tmp_path / "arm.xml").write_text(ROTOR)
    (tmp_path / "robot.toml").write_text(
        'name = "one"\nmodel = "arm.xml"\n[[joint]]\nname = "rotor"\n'
        'friction = { law = "coulomb", parameters = { coulomb = 1.0 } }\n'
        "events = [{ time = 3.0, coulomb = 1.0 }]\nposition_sensor = { offset = 0.1 }\n"
    )
    done = mjfriction("export", "--robot", tmp_path / "robot.toml", "--out", tmp_path / "plain.xml")
    assert done.returncode == 0, done.stderr
    assert "not in the model: events, position_sensor of rotor" in done.stdout


def test_a_folder_that_is_not_there_is_one_line() -> None:
    done = mjfriction("export", "--robot", "ur5", "--out", "/nowhere/arm.xml")
    assert done.returncode == 2
    assert done.stderr.count("\n") == 1


def test_only_a_name_that_says_mjcf_is_written(tmp_path) -> None:
    done = mjfriction("export", "--robot", "ur5", "--out", tmp_path / "arm.urdf")
    assert done.returncode == 2
    assert "give a name that ends in .xml" in done.stderr
    assert list(tmp_path.iterdir()) == []
