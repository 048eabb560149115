"""Robots whose links are wrong everywhere: told as that, with what is hidden besides; a single link is not."""

from __future__ import annotations

import functools
import tempfile
from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
import pytest

from mjfriction.diagnose.causes.catalog import STRUCTURAL
from mjfriction.diagnose.causes.cause import Site
from mjfriction.diagnose.causes.links import LinkScale
from mjfriction.diagnose.diagnosis import diagnose_log
from mjfriction.diagnose.fit import trial
from mjfriction.diagnose.fit.base_changes import base_changes
from mjfriction.diagnose.fit.exact import usual_nuisance
from mjfriction.diagnose.fit.intervals import half_widths
from mjfriction.diagnose.fit.model import Chosen, Model, build_model, cause_block
from mjfriction.diagnose.fit.nuisance import make_nuisance
from mjfriction.diagnose.fit.trial import try_out
from mjfriction.diagnose.search import free_links, second_look
from mjfriction.diagnose.search.compete import compete
from mjfriction.diagnose.search.field import make_field
from mjfriction.diagnose.search.free_links import compete_for_links
from mjfriction.diagnose.tell.outcome import Diagnosis, Verdict
from mjfriction.identify.measure import measure_gap
from mjfriction.record.log import Log
from mjfriction.record.readers import read_log
from mjfriction.robot.body_tables import LinkInertia
from mjfriction.robot.files import read_robot
from mjfriction.robot.predict import predict_log
from tests.hidden.machine import UR5, UR5_COULOMB, UR5_JOINTS, UR5_VISCOUS, Machine, mujoco_model, write_case

ELBOW, WRIST = 2, 4
NOISE = 0.1
SECONDS = 20.0


def other_links(model: mujoco.MjModel) -> None:
    """Make every link that moves as much as a third heavier or lighter, its centre centimetres off."""
    rng = np.random.default_rng(3)
    for body in range(2, model.nbody):
        factor = np.exp(rng.normal(0.0, 0.3))
        model.body_mass[body] *= factor
        model.body_inertia[body] *= factor * np.exp(rng.normal(0.0, 0.3))
        model.body_ipos[body] += rng.normal(0.0, 0.02, 3)


def one_link(model: mujoco.MjModel) -> None:
    body = model.body("forearm_link").id
    model.body_mass[body] *= 1.4
    model.body_inertia[body] *= 1.4


def true_links() -> dict[str, LinkInertia]:
    """Return the links that the machine has, in the joints' frames, as a robot file states them."""
    model = mujoco_model(UR5)
    other_links(model)
    out = {}
    for joint in UR5_JOINTS:
        body = model.jnt_bodyid[model.joint(joint).id]
        turned = np.empty(9)
        mujoco.mju_quat2Mat(turned, model.body_iquat[body])
        axes = turned.reshape(3, 3)
        moments = axes @ np.diag(model.body_inertia[body]) @ axes.T
        x, y, z = model.body_ipos[body].tolist()
        six = [float(moments[i, j]) for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))]
        out[joint] = LinkInertia(mass=float(model.body_mass[body]), com=(x, y, z), inertia=tuple(six))
    return out


ASYMMETRIC = {ELBOW: lambda at: 0.25 * UR5_VISCOUS[ELBOW] * np.abs(at.v)}
EVERYWHERE = Machine(change=other_links, hidden=ASYMMETRIC, noise=NOISE)


def diagnosed(folder: Path, machine: Machine, seed: int = 5) -> Diagnosis:
    log, robot = write_case(folder, machine, seed, seconds=SECONDS)
    return diagnose_log(read_log(log), read_robot(robot))


@functools.cache
def everywhere() -> Diagnosis:
    """Diagnose the robot that is wrong everywhere, once for all tests."""
    with tempfile.TemporaryDirectory() as folder:
        return diagnosed(Path(folder), EVERYWHERE)


def names(diagnosis: Diagnosis) -> set[tuple[str, str | None]]:
    return {(finding.cause, finding.joint) for finding in diagnosis.findings}


def another_motion(folder: Path) -> Log:
    return read_log(write_case(folder, EVERYWHERE, 77)[0])


def errors(diagnosis: Diagnosis, log: Log) -> list[float]:
    """Return the RMS error on each joint, relative to the noise, over what moves well."""
    predicted = predict_log(log, diagnosis.robot)
    left = [log.columns[f"effort.{name}"] - predicted[f"effort.{name}"] for name in UR5_JOINTS]
    # Reversals, where a filtered velocity blurs the direction of friction, are left out by the median.
    return [
        float(np.median(np.abs(own))) * 1.4826 / (NOISE * level) for own, level in zip(left, UR5_COULOMB, strict=True)
    ]


def test_links_that_are_wrong_everywhere_are_one_cause_and_the_other_is_found_beside_them() -> None:
    diagnosis = everywhere()
    assert names(diagnosis) == {("body.link_inertia", None), ("friction.asymmetry", UR5_JOINTS[ELBOW])}
    assert diagnosis.verdict is Verdict.EXPLAINED
    asymmetry = next(finding for finding in diagnosis.findings if finding.cause == "friction.asymmetry")
    assert asymmetry.parameters[0].low < 0.25 * UR5_VISCOUS[ELBOW] < asymmetry.parameters[0].high


def test_the_extended_robot_predicts_another_motion_to_the_noise(tmp_path: Path) -> None:
    assert max(errors(everywhere(), another_motion(tmp_path))) < 1.05


@pytest.mark.deep
def test_within_what_is_usual_many_links_would_be_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    free = everywhere()
    monkeypatch.setattr(second_look, "compete_for_links", compete)
    held = diagnosed(tmp_path, EVERYWHERE)
    assert len(held.findings) > len(free.findings)
    assert len(held.robot.table.link_inertia) < len(free.robot.table.link_inertia)


def let_go(folder: Path, seed: int) -> Model:
    log, robot = write_case(folder, EVERYWHERE, seed)
    gap = measure_gap(read_log(log), read_robot(robot))
    model, _ = compete_for_links(gap, usual_nuisance(gap), make_field(gap, STRUCTURAL))
    assert model.nuisance.inertias is not None
    return model


def held_by(model: Model) -> list[bool]:
    """Return which of the intervals of combinations that are told hold what the machine has."""
    robot, place, inertias = model.gap.robot, model.nuisance.of_inertias, model.nuisance.inertias
    assert inertias is not None
    gram = model.system.normal.products.whole[0][place, place]
    truth = replace(robot, table=robot.table.model_copy(update={"link_inertia": true_links()}))
    true = {one.name: one.value for one in inertias.fitted(truth, gram, np.zeros_like(gram), 0.0)}
    told = [fitted for _, fitted in base_changes(model, half_widths(model)).off]
    return [one.low < true[one.name] < one.high for one in told]


@pytest.mark.deep
def test_links_that_are_told_are_bodies_and_their_intervals_hold_the_truth(tmp_path: Path) -> None:
    model = let_go(tmp_path, 5)
    inertias, place = model.nuisance.inertias, model.nuisance.of_inertias
    assert inertias is not None
    assert not inertias.physical(model.strengths[place])  # as the rows would have them
    assert inertias.physical(model.built[place])
    free, built = (model.residual(built=as_bodies)[:, ELBOW] for as_bodies in (False, True))
    assert model.gap.rms(built, ELBOW) == pytest.approx(model.gap.rms(free, ELBOW), rel=0.01)
    held = held_by(model)
    assert len(held) > 10
    assert np.mean(held) > 0.9


@pytest.mark.deep
def test_nine_intervals_of_ten_hold_the_truth(tmp_path: Path) -> None:
    held = [one for seed in range(1, 13) for one in held_by(let_go(tmp_path / str(seed), seed))]
    assert np.mean(held) > 0.9


@pytest.mark.deep
def test_a_single_link_is_no_robot_that_is_wrong_everywhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    machine = Machine(change=one_link, noise=NOISE)
    found = diagnosed(tmp_path / "one", machine)
    assert names(found) == {("body.link_inertia", None)}
    assert [fitted.name for fitted in found.findings[0].parameters] == [f"link_scale.{UR5_JOINTS[ELBOW]}"]
    assert not found.robot.table.link_inertia
    # Without the price of freedoms it would be.
    monkeypatch.setattr(free_links, "_pays", lambda *_: True)
    assert diagnosed(tmp_path / "all", machine).robot.table.link_inertia


def test_a_link_is_judged_where_it_is_felt(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def stouter(model: mujoco.MjModel) -> None:
        body = model.body("upper_arm_link").id
        model.body_mass[body] *= 1.25
        model.body_inertia[body] *= 1.25

    log, robot = write_case(tmp_path, Machine(change=stouter), seed=5)
    gap = measure_gap(read_log(log), read_robot(robot))
    model = build_model(gap, make_nuisance(gap), ())
    heavier = Chosen(LinkScale(), Site(1))
    judged = try_out(model, heavier)
    assert judged is not None
    assert judged.passes(1000)
    # The elbow does not feel the upper arm, but gains most: its links had been bent to what the shoulder asks for.
    columns, _ = cause_block(gap, heavier)
    assert not np.any(columns[ELBOW])
    gained = model.heldout_errors - model.with_candidate(heavier).heldout_errors(gap.blocks.folds)
    assert int(np.argmax(gained.sum(axis=1))) == ELBOW
    monkeypatch.setattr(trial, "_feeling", list)
    unfelt = try_out(model, heavier)
    assert unfelt is not None
    assert not unfelt.passes(1000)


@pytest.mark.deep
def test_where_letting_go_loses_the_search_that_was_broken_off_goes_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    log, robot = write_case(tmp_path, EVERYWHERE, 5, seconds=SECONDS)
    gap = measure_gap(read_log(log), read_robot(robot))
    known, field = usual_nuisance(gap), make_field(gap, STRUCTURAL)
    monkeypatch.setattr(
        free_links, "_left", lambda model: np.full(len(UR5_JOINTS), 1.0 + bool(model.nuisance.inertias))
    )
    kept, _ = compete_for_links(gap, known, field)
    assert kept.nuisance.inertias is None
    plain, _ = compete(gap, known, field)
    assert {choice.key[:2] for choice in kept.chosen} == {choice.key[:2] for choice in plain.chosen}
