"""A bristle whose deflection is damped, as LuGre's is: stiffness and damping are told apart."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pyarrow as pa
import pytest

from mjfriction.diagnose import diagnosis
from mjfriction.diagnose.causes.cause import Site
from mjfriction.diagnose.causes.lugre_presliding import DampedLuGrePresliding, LuGreBristle, LuGrePresliding
from mjfriction.diagnose.causes.presliding import SLIPS, DampedPresliding, Presliding, SlippingElements
from mjfriction.diagnose.causes.stribeck import Stribeck
from mjfriction.diagnose.diagnosis import diagnose_log
from mjfriction.diagnose.fit.model import Chosen, build_model
from mjfriction.diagnose.fit.nuisance import make_nuisance
from mjfriction.diagnose.fit.shapes import best_shape
from mjfriction.diagnose.search import compete
from mjfriction.diagnose.search.field import make_field
from mjfriction.identify.gap import Gap
from mjfriction.identify.measure import measure_gap
from mjfriction.laws.catalog import find_law
from mjfriction.plant.machine import simulate
from mjfriction.plant.motions import excitation
from mjfriction.plant.sensors import Recorder
from mjfriction.record.readers import read_log
from mjfriction.record.readers.table import log_from_table
from mjfriction.robot.effort import predict_effort
from mjfriction.robot.files import read_robot
from mjfriction.robot.friction_tables import FrictionTerm
from mjfriction.robot.robot import Robot
from tests.hidden.machine import UR5_COULOMB, UR5_JOINTS, Instant, Machine, bristle, write_case

PAN, TRAVEL, DAMPING = 0, 0.02, 20.0


def damped(at: Instant) -> np.ndarray:
    built = bristle(at.q, TRAVEL)
    along = np.sign(at.v)
    return UR5_COULOMB[PAN] * (built - along) + DAMPING * at.v * (1.0 - built * along)


def found(folder: Path) -> dict[str, float]:
    log, robot = write_case(folder, Machine(hidden={PAN: damped}), seed=4)
    diagnosed = diagnose_log(read_log(log), read_robot(robot))
    (finding,) = diagnosed.findings
    assert (finding.cause, finding.joint) == ("friction.presliding", UR5_JOINTS[PAN])
    (law,) = [term.law for term in diagnosed.robot.joint(UR5_JOINTS[PAN]).friction or () if "bristle" in str(term)]
    return {value.name: value.value for value in finding.parameters} | {law: 1.0}


@pytest.mark.deep
def test_stiffness_and_damping_are_told_apart(tmp_path: Path) -> None:
    told = found(tmp_path)
    assert told["presliding_travel"] == pytest.approx(TRAVEL, rel=0.05)
    assert told["bristle_damping"] == pytest.approx(DAMPING, rel=0.05)
    assert "lugre" in told


@pytest.mark.parametrize("cause", [Presliding(), DampedPresliding(), SlippingElements()])
def test_where_no_level_is_stated_none_builds_up(cause: Presliding | DampedPresliding | SlippingElements) -> None:
    # A robot that states no friction has its levels refitted along; they are not built in yet when what bends is drawn.
    read = read_robot("linear_axis")
    stated = read.with_stated_friction(read.body())
    bare = stated.with_joint(stated.table.joint[0].model_copy(update={"friction": ()}))
    strengths = np.full(len(SLIPS), 2.0)
    assert cause.extend(bare, Site(0, (0.01,)), strengths) == bare
    assert cause.extend(stated, Site(0, (0.01,)), strengths) != stated


@pytest.mark.deep
def test_without_damping_the_travel_is_taken_for_shorter(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    others = tuple(cause for cause in diagnosis.STRUCTURAL if not isinstance(cause, DampedPresliding))
    monkeypatch.setattr(diagnosis, "STRUCTURAL", others)
    plain = found(tmp_path)
    assert "dahl" in plain
    assert plain["presliding_travel"] < 0.7 * TRAVEL


ELBOW, LEVEL = 2, 5.0
STATED = {"coulomb": LEVEL, "static": 1.5 * LEVEL, "stribeck_velocity": 0.08, "stribeck_exponent": 2.0, "viscous": 3.0}


def with_law(robot: Robot, law: str, **more: float) -> Robot:
    kept = {name: value for name, value in STATED.items() if name in {one.name for one in find_law(law).parameters}}
    term = FrictionTerm(law=law, parameters={**kept, **more})
    return robot.with_joint(robot.table.joint[ELBOW].model_copy(update={"friction": (term,)}))


def stribeck_gap(machine: Robot, stated: Robot) -> Gap:
    middle = np.array([0.0, -1.2, 1.2, -0.5, 0.5, 0.0])
    motion = excitation(stated.joints, middle, np.full(6, 0.8), np.full(6, 1.2), 40.0, seed=3)
    log = log_from_table(pa.table(simulate(machine, motion, recorder=Recorder(250.0), seed=1)), "elbow")
    return measure_gap(log, stated)


@pytest.mark.parametrize("cause", [LuGrePresliding(), DampedLuGrePresliding()])
def test_a_stated_stribeck_curve_builds_up_with_the_level(cause: LuGreBristle) -> None:
    stated = with_law(read_robot("ur5"), "stribeck")
    gap = stribeck_gap(stated, stated)
    site = Site(ELBOW, (0.03,))
    strengths = np.array([0.6 * LEVEL, 4.0])[: len(cause.quantities(gap, site))]
    extended = cause.extend(stated, site, strengths)
    before, after = (predict_effort(one, one.body(), gap.motion).total[:, ELBOW] for one in (stated, extended))
    expected = cause.samples(gap, site) @ strengths
    # How a law goes through zero within a sample is a matter of its own.
    sliding = np.abs(gap.motion.velocity[:, ELBOW]) > 3.0 * gap.doubt_speed[ELBOW]
    error = (after - before - expected)[sliding]
    assert np.sqrt(np.mean(np.square(error))) < 0.01 * np.sqrt(np.mean(np.square(expected[sliding])))
    kept, built = extended.table.joint[ELBOW].friction or ()
    assert kept.value("static") - kept.value("coulomb") == pytest.approx(0.4 * 0.5 * LEVEL)
    assert built.value("static") == pytest.approx(1.5 * 0.6 * LEVEL)


def test_a_lugre_contact_whose_stribeck_curve_is_stated_is_told_with_its_own_values() -> None:
    travel = 0.01
    stated = with_law(read_robot("ur5"), "stribeck")
    machine = with_law(stated, "lugre", bristle_stiffness=LEVEL / travel, bristle_damping=10.0)
    gap = stribeck_gap(machine, stated)
    bristle = best_shape(
        build_model(gap, make_nuisance(gap), ()), Chosen(DampedLuGrePresliding(), Site(ELBOW, (travel,)))
    )
    model = build_model(gap, make_nuisance(gap), (bristle,))
    level, damping = model.strengths[model.places[0]]
    assert bristle.site.shape[0] == pytest.approx(travel, rel=0.03)
    assert level == pytest.approx(LEVEL, rel=0.02)
    assert damping == pytest.approx(10.0, rel=0.05)


def test_a_curve_that_was_found_stays_as_it_is_whichever_is_built_in_first() -> None:
    stated = with_law(read_robot("ur5"), "stribeck")
    found = Stribeck(), Site(ELBOW, (0.3, 1.0)), np.array([2.0])
    built = LuGrePresliding(), Site(ELBOW, (0.02,)), np.array([0.6 * LEVEL])
    robots = []
    for order in ((found, built), (built, found)):
        robot = stated
        for cause, site, strengths in order:
            robot = cause.extend(robot, site, strengths)
        robots.append({(term.law, tuple(term.parameters.values())) for term in robot.table.joint[ELBOW].friction or ()})
    assert robots[0] == robots[1]
    assert len(robots[0]) == 3


@pytest.mark.deep
def test_a_curve_that_is_stated_and_not_there_is_told_beside_presliding() -> None:
    stated = with_law(read_robot("ur5"), "stribeck")
    machine = with_law(stated, "dahl", bristle_stiffness=LEVEL / 0.02, shape_exponent=1.0)
    log = stribeck_gap(machine, stated).log
    told = {(one.cause, one.joint) for one in diagnose_log(log, stated).findings}
    assert told == {("friction.presliding", UR5_JOINTS[ELBOW]), ("friction.stribeck", UR5_JOINTS[ELBOW])}


def tried(cause: Presliding | DampedPresliding, merit: float) -> Any:
    return SimpleNamespace(chosen=Chosen(cause, Site(ELBOW, shape=(1e-3,))), merit=merit)


@pytest.mark.parametrize(("ahead", "chosen"), [(5.0, Presliding), (15.0, DampedPresliding)])
def test_the_damping_counts_where_it_pays_for_itself(
    ahead: float, chosen: type[Presliding | DampedPresliding], tmp_path: Path
) -> None:
    # It fits a late effort too, and would stand in for that.
    log, robot = write_case(tmp_path, Machine(), seed=4, seconds=15.0)
    gap = measure_gap(read_log(log), read_robot(robot))
    model = build_model(gap, make_nuisance(gap), ())
    field = make_field(gap, (Presliding(), DampedPresliding()))
    best = compete._best(model, field, [tried(Presliding(), 200.0), tried(DampedPresliding(), 200.0 + ahead)])
    assert type(best.chosen.cause) is chosen


def test_where_a_bristle_was_refused_its_damped_form_is_too(tmp_path: Path) -> None:
    log, robot = write_case(tmp_path, Machine(), seed=4, seconds=15.0)
    field = make_field(measure_gap(read_log(log), read_robot(robot)), (Presliding(), DampedPresliding()))
    left = compete._without_richer(field, [tried(Presliding(), 0.0).chosen])
    assert {one.joint for one in field if one not in left} == {ELBOW}
    assert {type(one.cause) for one in field if one not in left} == {DampedPresliding}
