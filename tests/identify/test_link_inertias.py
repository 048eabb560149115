"""Links whose inertias are wrong throughout are found from free motion, and are always such as bodies can have."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np
import pinocchio as pin
import pyarrow as pa
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mjfriction.body.inertia import FINEST, factors, parameters_per_number, pseudo_inertias, symmetric
from mjfriction.body.model import load_body
from mjfriction.body.regressor import weighed_links
from mjfriction.identify.base_parameters import base_parameters
from mjfriction.identify.identification import identify_log
from mjfriction.identify.link_inertias import nearest_physical
from mjfriction.identify.measure import measure_gap
from mjfriction.record.readers.table import log_from_table
from mjfriction.robot.body_tables import Payload
from mjfriction.robot.files import read_robot, write_robot
from mjfriction.robot.robot import Robot
from tests.hidden.machine import UR5, UR5_COULOMB, UR5_JOINTS, Machine, record, robot_toml

NOISE = 0.03  # of the Coulomb levels


def wrong_throughout(model: mujoco.MjModel) -> None:
    """Links up to 30 % heavier, their centres up to 4 cm elsewhere, their moments up to 40 % larger."""
    rng = np.random.default_rng(3)
    for body in range(1, model.nbody):
        if model.body_mass[body] > 0.1:
            model.body_mass[body] *= 1.0 + 0.3 * rng.uniform()
            model.body_ipos[body] += 0.04 * rng.uniform(-1.0, 1.0, 3)
            model.body_inertia[body] *= 1.0 + 0.4 * rng.uniform()


def test_a_model_wrong_throughout_is_put_right(tmp_path: Path) -> None:
    machine = Machine(noise=NOISE, change=wrong_throughout)
    (tmp_path / "robot.toml").write_text(robot_toml(machine, off=0.2), encoding="utf-8")
    stated = read_robot(tmp_path / "robot.toml")
    log, other = (log_from_table(pa.table(record(machine, seed, 40.0)), "wrong") for seed in (5, 6))
    found = identify_log(log, stated, law="coulomb_viscous")
    kept = identify_log(log, stated, law="coulomb_viscous", links=False)
    (tmp_path / "out").mkdir()
    written = read_robot(write_robot(found.robot, tmp_path / "out"))
    assert set(written.table.link_inertia) <= set(UR5_JOINTS)

    def missed(robot: Robot) -> np.ndarray:  # in deviations of the sensors' noise, on motion that was not fitted
        gap = measure_gap(other, robot)
        return np.array([gap.rms(gap.residual[:, j], j) for j in range(6)]) / gap.noise_floor

    assert np.all(missed(written) < 1.1)
    assert np.max(missed(kept.robot)) > 5.0
    # What friction is told to be does not suffer: without the links it does.
    levels = [[next(p.value for p in law.parameters if p.name == "coulomb") for law in i.laws] for i in (found, kept)]
    wrong = [np.max(np.abs(np.array(own) / UR5_COULOMB - 1.0)) for own in levels]
    assert wrong[0] < 0.05 < wrong[1]
    # Base parameters carry the truth of the sum that shows, whatever its parts are.
    assert len([fitted for fitted in found.background if "." in fitted.name]) > 20


def test_a_link_that_no_body_could_be_is_near_one_that_can() -> None:
    # Many a robot's file has a moment of inertia that is more than its two others together.
    moments = np.diag([0.073, 0.016, 0.0924])
    stated = pin.PseudoInertia.FromInertia(pin.Inertia(4.96, np.array([0.0, -0.083, 0.015]), moments)).toMatrix()
    assert np.min(np.linalg.eigvalsh(stated)) < -1e-3
    (factor,) = factors(stated[None])
    near = factor @ factor.T
    assert np.min(np.linalg.eigvalsh(near)) > 0.0
    np.testing.assert_allclose(near[3], stated[3])
    spread = np.diag([4.96 * FINEST**2] * 3 + [0.0])
    assert np.linalg.norm(near - spread - stated) == pytest.approx(0.5 * (0.0924 - 0.073 - 0.016))


@pytest.mark.deep
def test_a_stated_payload_becomes_part_of_the_link_that_holds_it(tmp_path: Path) -> None:
    machine = Machine(noise=NOISE)
    (tmp_path / "robot.toml").write_text(robot_toml(machine), encoding="utf-8")
    bare = read_robot(tmp_path / "robot.toml")
    held = Payload(mass=0.3, com=(0.0, 0.0, 0.05), parent="wrist_3_link")  # stated, and not there
    loaded = Robot(bare.table.model_copy(update={"payload": held}), bare.folder)
    log = log_from_table(pa.table(record(machine, 5, 40.0)), "bare")
    found = identify_log(log, loaded, law="coulomb_viscous").robot
    assert found.table.payload is None
    assert "wrist_3_joint" in found.table.link_inertia
    gap = measure_gap(log, found)
    assert all(gap.rms(gap.residual[:, j], j) < 1.1 * gap.noise_floor[j] for j in range(6))


def test_base_parameters_are_as_many_as_the_regressor_has_rank() -> None:
    body = load_body(UR5, UR5_JOINTS)
    rng = np.random.default_rng(0)
    motion = [rng.normal(size=(200, 6)) for _ in range(3)]
    pseudo = pseudo_inertias(body.model)
    weight = parameters_per_number(factors(pseudo))
    columns = weighed_links(body, *motion, weight).reshape(1200, -1)
    data = body.model.createData()
    stacked = np.vstack(
        [pin.computeJointTorqueRegressor(body.model, data, *state) for state in zip(*motion, strict=True)]
    )
    rank = np.linalg.matrix_rank(stacked, tol=1e-9 * np.linalg.norm(stacked))
    assert rank == 36  # Gautier and Khalil's number for six hinges of which the first is vertical
    known = 1e12 * columns.T @ columns
    values = np.concatenate([inertia.toDynamicParameters() for inertia in list(body.model.inertias)[1:]])
    found = base_parameters(body.links, values, values, weight, known, np.linalg.pinv(known), 2.0)
    assert len(found) == rank


def test_base_parameters_say_the_same_of_links_that_no_motion_tells_apart() -> None:
    # What is taken from one link and given to another, along what the regressor does not see, leaves them as they are.
    body = load_body(UR5, UR5_JOINTS)
    rng = np.random.default_rng(1)
    motion = [rng.normal(size=(200, 6)) for _ in range(3)]
    weight = parameters_per_number(factors(pseudo_inertias(body.model)))
    columns = weighed_links(body, *motion, weight).reshape(1200, -1)
    unseen = np.linalg.svd(columns)[2][36:].T @ rng.normal(size=24)
    gram = 1e12 * columns.T @ columns
    values = np.concatenate([inertia.toDynamicParameters() for inertia in list(body.model.inertias)[1:]])
    moved = values + np.einsum("lij,lj->li", weight, unseen.reshape(6, 10)).ravel()
    assert np.max(np.abs(moved - values)) > 0.1
    both = [
        base_parameters(body.links, own, values, weight, gram, np.linalg.pinv(gram), 2.0) for own in (values, moved)
    ]
    for one, two in zip(*both, strict=True):
        assert two.value == pytest.approx(one.value, abs=1e-7)


@given(st.integers(0, 2**32 - 1))
def test_the_nearest_physical_links_are_the_fit_where_that_is_physical(seed: int) -> None:
    rng = np.random.default_rng(seed)
    root = rng.normal(size=(40, 23))
    strengths = 0.05 * rng.normal(size=23)
    gram = root.T @ root
    found = nearest_physical(gram, gram @ strengths, slice(3, 23), np.array([np.eye(4)] * 2))
    np.testing.assert_allclose(found, strengths, atol=1e-5)


@pytest.mark.deep
@settings(max_examples=15)
@given(st.integers(0, 2**32 - 1))
def test_no_physical_links_near_by_fit_better(seed: int) -> None:
    rng = np.random.default_rng(seed)
    root = rng.normal(size=(40, 13))
    gram, moment = root.T @ root, root.T @ root @ np.concatenate([rng.normal(size=3), 2.0 * rng.normal(size=10)])

    def cost(s: np.ndarray) -> float:
        return float(0.5 * s @ gram @ s - moment @ s)

    found = nearest_physical(gram, moment, slice(3, 13), np.eye(4)[None])
    own = found[3:]
    assert np.linalg.eigvalsh(np.eye(4) + symmetric(own))[0] > -1e-9
    # Bodies are convex: towards any other that is physical, the fit gets no better.
    for _ in range(20):
        lower = np.tril(rng.normal(size=(4, 4)))
        other = lower @ lower.T - np.eye(4)
        rows, columns = np.tril_indices(4)
        numbers = other[rows, columns] * np.where(rows == columns, 1.0, np.sqrt(2.0))
        step = np.concatenate([np.zeros(3), 1e-4 * (numbers - own)])
        assert cost(found + step) >= cost(found) - 1e-6 * abs(cost(found))
