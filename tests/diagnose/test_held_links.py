"""One cause in the place of all links: it is one that nature allows, and stands out from what levels may be off by."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace

import mujoco
import numpy as np
import pytest

from mjfriction.diagnose.causes.catalog import STRUCTURAL
from mjfriction.diagnose.causes.cause import Site
from mjfriction.diagnose.causes.gravity_direction import GravityDirection
from mjfriction.diagnose.causes.links import LEAST_NOTED, LinkCentre, LoneWholeLink
from mjfriction.diagnose.causes.spring import Spring
from mjfriction.diagnose.causes.viscous_nonlinear import ViscousNonlinear
from mjfriction.diagnose.fit.as_little import leaves_as_little
from mjfriction.diagnose.fit.exact import least_off, level_changes, may_be_off
from mjfriction.diagnose.fit.intervals import half_widths
from mjfriction.diagnose.fit.model import Chosen, Model, build_model
from mjfriction.diagnose.fit.nuisance import make_nuisance
from mjfriction.diagnose.fit.tangent import straightened
from mjfriction.diagnose.search.field import make_field
from mjfriction.diagnose.settle.held_links import _stand_out as stand_out
from mjfriction.diagnose.settle.held_links import held_links
from mjfriction.diagnose.settle.stated import _nearer_links
from mjfriction.diagnose.tell import link_finding
from mjfriction.identify.gap import Gap
from mjfriction.identify.measure import measure_gap
from mjfriction.record.readers import read_log
from mjfriction.robot.files import read_robot
from tests.hidden.machine import Machine, write_case

TILTED = (-9.785, -0.26, 0.65)  # m/s², of an arm on a wall


def tilted_and_off(model: mujoco.MjModel) -> None:
    model.opt.gravity[:] = TILTED
    scale = 1.0 + 0.02 * np.random.default_rng(5).standard_normal(model.nbody)
    model.body_mass *= scale
    model.body_inertia *= scale[:, None]


def on_a_wall(folder: Path) -> Gap:
    log, robot = write_case(folder, Machine(change=tilted_and_off, noise=0.1), seed=5)
    robot.write_text("gravity = [-9.81, 0.0, 0.0]\n" + robot.read_text())
    return measure_gap(read_log(log), read_robot(robot))


def test_a_zero_that_turns_gravity_as_a_tilt_does_stands_for_no_links(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # The first joint of an arm on a wall turns about an axis that is level: its zero is one of the tilt's two numbers.
    gap = on_a_wall(tmp_path)
    tilt = Chosen(GravityDirection(), Site(0))
    model = straightened(build_model(gap, make_nuisance(gap), (tilt,)))
    zero = tuple(
        one for one in make_field(gap, STRUCTURAL) if (one.cause.name, one.joint) == ("sensor.encoder_offset", 0)
    )
    right = dict.fromkeys(gap.examined, 0.0)
    assert held_links(model, zero, right, right) is model
    # Without that a zero many turns off was told, and a gravity of 250 m/s² against it.
    monkeypatch.setattr(Model, "admissible", lambda self: self)
    monkeypatch.setattr("mjfriction.diagnose.settle.held_links.pruned", lambda alone, _: alone)
    alone = held_links(model, zero, right, right)
    assert [choice.cause.name for choice in alone.chosen] == ["body.gravity_direction", "sensor.encoder_offset"]
    assert abs(alone.strengths[alone.places[1]][0]) > 2.0 * np.pi


def heavier(model: mujoco.MjModel) -> None:
    body = model.body("forearm_link").id
    model.body_mass[body] *= 1.045
    model.body_inertia[body] *= 1.045


@pytest.mark.parametrize(("most", "named"), [(0.002, True), (0.008, True), (0.02, False)])
def test_links_are_off_by_more_than_levels_may_be(tmp_path: Path, most: float, *, named: bool) -> None:
    log, robot = write_case(tmp_path, Machine(change=heavier, noise=0.1), seed=5)
    gap = measure_gap(read_log(log), read_robot(robot))
    model = build_model(gap, make_nuisance(gap), ())
    right = dict.fromkeys(gap.examined, 0.0)
    held = held_links(model, make_field(gap, STRUCTURAL), right, dict.fromkeys(gap.examined, most))
    assert [choice.cause.name for choice in held.chosen] == (["body.link_inertia"] if named else [])


@pytest.mark.parametrize(("off", "named"), [(0.015, True), (0.025, False)])
def test_friction_has_to_be_nearly_right_throughout(tmp_path: Path, off: float, *, named: bool) -> None:
    log, robot = write_case(tmp_path, Machine(change=heavier, noise=0.1), seed=5)
    gap = measure_gap(read_log(log), read_robot(robot))
    model = build_model(gap, make_nuisance(gap), ())
    surely, may_be = dict.fromkeys(gap.examined, off), dict.fromkeys(gap.examined, 0.002)
    held = held_links(model, make_field(gap, STRUCTURAL), surely, may_be)
    assert [choice.cause.name for choice in held.chosen] == (["body.link_inertia"] if named else [])


@pytest.mark.parametrize(("bent", "named"), [((), False), ((1, 2), True), ((1, 2, 3, 4), False)])
def test_levels_beside_a_bend_do_not_tell_how_exactly_a_robot_is_stated(
    tmp_path: Path, bent: tuple[int, ...], *, named: bool
) -> None:
    log, robot = write_case(tmp_path, Machine(change=heavier, noise=0.1), seed=5)
    gap = measure_gap(read_log(log), read_robot(robot))
    model = build_model(gap, make_nuisance(gap), tuple(Chosen(ViscousNonlinear(), Site(joint)) for joint in bent))
    surely = dict.fromkeys(gap.examined, 0.0) | {1: 0.1, 2: 0.1}
    held = held_links(model, make_field(gap, STRUCTURAL), surely, dict.fromkeys(gap.examined, 0.002))
    assert any(choice.cause.name == "body.link_inertia" for choice in held.chosen) is named


def test_what_stood_in_for_a_part_of_the_one_cause_goes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    log, robot = write_case(tmp_path, Machine(change=heavier, noise=0.1), seed=5)
    gap = measure_gap(read_log(log), read_robot(robot))
    right, spring = dict.fromkeys(gap.examined, 0.0), Chosen(Spring(), Site(2))
    model = build_model(gap, make_nuisance(gap), (spring,))

    def kept() -> list[str]:
        held = held_links(model, make_field(gap, STRUCTURAL), right, dict.fromkeys(gap.examined, 0.002))
        return [choice.cause.name for choice in held.chosen]

    assert kept() == ["body.link_inertia"]
    monkeypatch.setattr("mjfriction.diagnose.settle.held_links.pruned", lambda alone, _: alone)
    assert kept() == ["body.spring", "body.link_inertia"]


def test_what_noise_leaves_open_may_be_off(tmp_path: Path) -> None:
    log, robot = write_case(tmp_path, Machine(noise=0.6), seed=9, seconds=14.0, rate=100.0)
    gap = measure_gap(read_log(log), read_robot(robot))
    model = build_model(gap, make_nuisance(gap), ())
    least, seeming, most = least_off(model), level_changes(model), may_be_off(model)
    for joint in gap.examined:
        assert least[joint] <= seeming[joint] <= most[joint]
    assert max(most.values()) > 0.01 > float(np.median(list(least.values())))


@pytest.mark.parametrize(("off", "named"), [(0.0, True), (0.02, True), (0.03, False)])
def test_a_link_is_off_by_more_than_levels_are(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, off: float, *, named: bool
) -> None:
    def stouter(model: mujoco.MjModel) -> None:
        body = model.body("upper_arm_link").id
        model.body_mass[body] *= 1.09
        model.body_inertia[body] *= 1.09

    log, robot = write_case(tmp_path, Machine(change=stouter, noise=0.1), seed=5)
    gap = measure_gap(read_log(log), read_robot(robot))
    model = build_model(gap, make_nuisance(gap), ())
    assert LEAST_NOTED < float(np.max(np.abs(model.link_changes[:, 0]))) < link_finding.ALWAYS_NOTED
    monkeypatch.setattr(link_finding, "levels_off", lambda _: off)
    found = link_finding._scaled(model, half_widths(model), make_field(gap, STRUCTURAL))
    assert (found is not None) is named


@pytest.mark.parametrize(
    ("scale", "moved", "most", "stands"),
    [
        (0.03, 0.0, 0.005, True),
        (0.01, 0.0, 0.005, False),
        (0.0, 0.004, 0.005, True),
        (0.0, 0.002, 0.005, False),
    ],
)
def test_scale_or_centre_is_enough_for_links_to_stand_out(
    scale: float, moved: float, most: float, *, stands: bool
) -> None:
    links = SimpleNamespace(link_changes=np.array([[0.0, 0.0, 0.0, 0.0], [scale, 0.0, moved, 0.0]]))
    alone = SimpleNamespace(chosen=(Chosen(LoneWholeLink(), Site(1)),), gap=SimpleNamespace(examined=(0, 1, 2)))
    assert stand_out(links, alone, dict.fromkeys(range(3), most)) is stands  # type: ignore[arg-type]


@pytest.mark.parametrize(("most", "stands"), [(0.002, True), (0.05, False)])
def test_a_centre_far_off_stands_out_by_itself(most: float, *, stands: bool) -> None:
    centre = Chosen(LinkCentre(), Site(1))
    alone = SimpleNamespace(
        chosen=(centre,),
        gap=SimpleNamespace(examined=(0, 1, 2)),
        strengths=np.array([0.03, 0.0, 0.0]),
        places=[slice(3)],
    )
    assert stand_out(None, alone, dict.fromkeys(range(3), most)) is stands  # type: ignore[arg-type]


@pytest.mark.parametrize("off", [0.0, 0.03])
def test_links_of_a_robot_stated_exactly_are_no_more_off_than_it_takes(off: float, tmp_path: Path) -> None:
    def stouter(model: mujoco.MjModel) -> None:
        body = model.body("forearm_link").id
        model.body_mass[body] *= 1.004
        model.body_inertia[body] *= 1.004

    log, robot = write_case(tmp_path, Machine(change=stouter, noise=0.1), seed=5, off=off)
    gap = measure_gap(read_log(log), read_robot(robot))
    model = build_model(gap, make_nuisance(gap), ())
    near = _nearer_links(model)
    assert leaves_as_little(near, model)
    least = 0.5 * float(np.linalg.norm(model.link_changes))
    assert (float(np.linalg.norm(near.link_changes)) < least) is (off == 0.0)
