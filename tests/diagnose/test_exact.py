"""Where all else is stated exactly, a link a few percent off is a finding; where it is not, that is refitted along."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace

import mujoco
import numpy as np
import pytest

from mjfriction.diagnose.causes.links import LoneLink
from mjfriction.diagnose.diagnosis import diagnose_log
from mjfriction.diagnose.fit import exact
from mjfriction.diagnose.fit.exact import level_changes, stated_exactly, usual_nuisance
from mjfriction.diagnose.fit.model import build_model
from mjfriction.diagnose.fit.nuisance import make_nuisance
from mjfriction.diagnose.settle import held_links, stated
from mjfriction.diagnose.tell.outcome import Diagnosis
from mjfriction.identify.measure import measure_gap
from mjfriction.identify.regression import Rows, System
from mjfriction.record.readers import read_log
from mjfriction.robot.files import read_robot
from tests.hidden.machine import UR5_COULOMB, UR5_JOINTS, UR5_VISCOUS, Machine, write_case

SCALE = 1.06


def stouter(model: mujoco.MjModel) -> None:
    body = model.body("forearm_link").id
    model.body_mass[body] *= SCALE
    model.body_inertia[body] *= SCALE


def diagnosed(folder: Path, off: float, change: Callable[[mujoco.MjModel], None] = stouter) -> Diagnosis:
    log, robot = write_case(folder, Machine(change=change, noise=0.1), seed=5, off=off)
    return diagnose_log(read_log(log), read_robot(robot))


@pytest.mark.deep
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


@pytest.mark.deep
def test_so_is_one_that_is_lighter_and_elsewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    lighter, shift = 0.95, np.array([0.004, 0.0, 0.008])

    def changed(model: mujoco.MjModel) -> None:
        body = model.body("forearm_link").id
        model.body_mass[body] *= lighter
        model.body_inertia[body] *= lighter
        model.body_ipos[body] += shift

    (finding,) = diagnosed(tmp_path / "exact", 0.0, changed).findings
    assert finding.cause == "body.link_inertia"
    told = {value.name: value for value in finding.parameters}
    true = {"link_scale": lighter, **{f"link_shift_{x}": s for x, s in zip("xyz", shift, strict=True)}}
    assert told.keys() == {f"{name}.elbow_joint" for name in true}
    for name, value in true.items():
        own = told[f"{name}.elbow_joint"]
        assert abs(own.value - value) < 2.0 * (own.high - own.value), name
    # Neither half alone leaves as little, so that all would be refitted along.
    monkeypatch.setattr(held_links, "LoneWholeLink", LoneLink)
    assert diagnosed(tmp_path / "halves", 0.0, changed).findings == ()


def test_beside_friction_that_is_off_it_is_refitted_along(tmp_path: Path) -> None:
    found = diagnosed(tmp_path, 0.04)
    assert found.findings == ()
    assert [change for change in found.adjustments if change.what.startswith("link")]


@pytest.mark.parametrize(("left", "good"), [(0.92, True), (1.1, True), (1.3, True), (3.0, False)])
def test_one_cause_is_as_good_as_all_links_by_what_is_left_or_by_what_is_taken(left: float, good: bool) -> None:
    # All links leave 0.9 of 10: a cause that leaves 1.3 takes all but a percent of what they take.
    gap = SimpleNamespace(examined=(0,), rms=lambda course, _: float(np.sqrt(np.mean(np.square(course)))))
    alone, links, bare = (
        SimpleNamespace(gap=gap, heldout_residual=lambda size=size: np.full((4, 1), size)) for size in (left, 0.9, 10.0)
    )
    assert held_links._as_good(alone, links, bare) is good  # type: ignore[arg-type]
    small = SimpleNamespace(gap=gap, heldout_residual=lambda: np.full((4, 1), 1.0))
    assert not held_links._as_good(alone, links, small)  # type: ignore[arg-type]


@pytest.mark.parametrize(("needed", "help_"), [(0.06, True), (0.03, False)])
def test_links_help_where_a_drive_alone_would_have_to_go_farther_than_it_may(needed: float, *, help_: bool) -> None:
    """A drive and a link that do the same: together they may do twice what one may."""
    rng, blocks, reach = np.random.default_rng(1), 12, 0.045
    column = rng.standard_normal((blocks * 40, 1))
    target = needed * column + 1e-3 * rng.standard_normal(column.shape)
    rows = Rows(target, np.full_like(target, 1e3), np.repeat(np.arange(blocks), 40))
    near = np.full(2, (reach / 3.0) ** -2.0)
    normal = System(rows, [{0: column}, {0: column}], [near[:1], near[1:]]).normal.kept_within(
        slice(0, 2), np.full(2, reach)
    )
    folds = [np.arange(blocks) % 4 == fold for fold in range(4)]
    model = SimpleNamespace(
        nuisance=SimpleNamespace(precision=near, count=2, of_bounded=slice(0, 2), reach=np.full(2, reach)),
        system=SimpleNamespace(normal=normal),
        gap=SimpleNamespace(blocks=SimpleNamespace(folds=folds)),
        heldout_errors=normal.heldout_errors(folds),
    )
    assert stated._helps(model, slice(1, 2)) is help_  # type: ignore[arg-type]


def bar(off: dict[int, float]) -> float:
    return stated._bar(off, 0, off)


def test_of_two_other_joints_one_that_is_far_off_says_nothing_of_the_third() -> None:
    far, near, own = 0.24, 0.02, 0.17
    assert own > bar({0: own, 1: near, 2: far}) == stated.LEAST_CHANGE_ROUGH
    # Where both are off, so may the third be.
    assert own < bar({0: own, 1: 0.08, 2: far})
    # Of five others most have to be off.
    assert bar({0: own, **dict.fromkeys((1, 2, 3), near), 4: near, 5: far}) == stated.LEAST_CHANGE_ROUGH
    assert bar({0: own, 1: near, 2: 0.06, 3: 0.06, 4: 0.06, 5: far}) == pytest.approx(0.18)
    # That a robot is stated exactly takes both.
    assert bar({0: own, 1: 0.005, 2: far}) == stated.LEAST_CHANGE_ROUGH
    assert bar({0: own, 1: 0.005, 2: 0.009}) == stated.LEAST_CHANGE


@pytest.mark.deep
def test_levels_that_are_off_to_either_side_are_off(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # Coulomb friction a little less than stated, viscous more: at usual speeds that is no change, but no exactness.
    log, robot = write_case(tmp_path, Machine(noise=0.05), seed=5)
    text = robot.read_text()
    for joint, (coulomb, viscous) in {0: (1.02, 0.97), 4: (0.98, 1.03), 5: (1.12, 1.02)}.items():
        own = f"coulomb = {UR5_COULOMB[joint]}, viscous = {UR5_VISCOUS[joint]}"
        assert own in text
        text = text.replace(
            own, f"coulomb = {coulomb * UR5_COULOMB[joint]:.6g}, viscous = {viscous * UR5_VISCOUS[joint]:.6g}"
        )
    robot.write_text(text)

    def named() -> list[tuple[str, str | None]]:
        return [(one.cause, one.joint) for one in diagnose_log(read_log(log), read_robot(robot)).findings]

    assert named() == []
    monkeypatch.setattr(stated, "least_off", level_changes)
    assert named() == [("friction.coulomb_viscous", UR5_JOINTS[5])]


@pytest.mark.parametrize(("off", "exactly"), [(0.0, True), (0.06, False)])
def test_what_noise_makes_of_a_fit_is_no_inexactness(off: float, tmp_path: Path, *, exactly: bool) -> None:
    # A short and noisy log, of which no friction level is known to a percent.
    log, robot = write_case(tmp_path, Machine(noise=0.6), seed=9, off=off, seconds=14.0, rate=100.0)
    gap = measure_gap(read_log(log), read_robot(robot))
    model = build_model(gap, make_nuisance(gap), ())
    assert exact.typical(list(level_changes(model).values())) > exact.EXACT
    assert (exact.typical(list(exact.least_off(model).values())) < exact.EXACT) is exactly


@pytest.mark.parametrize("off", [0.0, 0.04])
def test_by_how_much_levels_are_off_one_by_one(off: float, tmp_path: Path) -> None:
    # Of a level up and a damping down little is left in a joint's friction, but both are off.
    log, robot = write_case(tmp_path, Machine(noise=0.1), seed=5)
    text = robot.read_text()
    for coulomb, viscous in zip(UR5_COULOMB, UR5_VISCOUS, strict=True):
        own = f"coulomb = {coulomb}, viscous = {viscous}"
        assert own in text
        text = text.replace(own, f"coulomb = {coulomb * (1.0 + off)}, viscous = {viscous * (1.0 - off)}")
    robot.write_text(text)
    gap = measure_gap(read_log(log), read_robot(robot))
    model = build_model(gap, make_nuisance(gap), ())
    assert exact.levels_off(model) == pytest.approx(off, abs=0.006)
    if off:
        assert max(level_changes(model).values()) < 0.6 * off


def test_one_torque_constant_that_is_off_is_no_reason_to_let_all_drives_go(tmp_path: Path) -> None:
    scaled = Machine(hidden={1: lambda at: -0.3 * (at.rigid + at.friction)}, pauses=True)
    log, robot = write_case(tmp_path, scaled, seed=5, seconds=30.0)
    gap = measure_gap(read_log(log), read_robot(robot))
    # The links that are refitted along make up for some of it, and others' friction for that.
    assert not stated_exactly(build_model(gap, make_nuisance(gap), ()))
    assert usual_nuisance(gap).drives == ()


def test_drives_are_let_go_where_friction_is_off_throughout(tmp_path: Path) -> None:
    log, robot = write_case(tmp_path, Machine(), seed=5, off=0.04, seconds=30.0)
    assert usual_nuisance(measure_gap(read_log(log), read_robot(robot))).drives
