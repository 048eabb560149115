"""Passes forward and backward: planned, run in MuJoCo, found in the log, and turned into a law."""

from __future__ import annotations

import functools
from dataclasses import replace

import numpy as np
import pyarrow as pa
import pytest

from mjfriction.body.gravity_pose import GravityClass, gravity_pose
from mjfriction.body.inverse import inverse_dynamics
from mjfriction.errors import LogError, RobotError
from mjfriction.identify.friction_map import FrictionMap
from mjfriction.identify.identification import identify_log
from mjfriction.identify.map_choice import choose_on_map
from mjfriction.identify.map_fit import arctan_procedure, fit_map
from mjfriction.identify.measure import measure_gap
from mjfriction.identify.outcome import Identification
from mjfriction.identify.phases import constant_speed_phases
from mjfriction.identify.protocol import (
    DRAWS,
    UNSTATED_SPEED,
    joined,
    least_told,
    motion_along,
    plan_excitation,
    plan_passes,
    plan_separation,
    room,
)
from mjfriction.laws.ambient import ambient
from mjfriction.laws.arctan import ARCTAN
from mjfriction.laws.catalog import find_law
from mjfriction.laws.stribeck import STRIBECK
from mjfriction.plant.machine import simulate
from mjfriction.plant.motions import excitation, trapezoid
from mjfriction.plant.sensors import Recorder
from mjfriction.record.readers.table import log_from_table
from mjfriction.report.html import identified_html
from mjfriction.report.identified import make_identified_report
from mjfriction.robot.files import read_robot
from mjfriction.robot.friction_tables import FrictionTerm
from mjfriction.robot.robot import Robot

ELBOW = 2
# Table 1 of the manipulator paper, joint 3, a tenth of it: the UR5 is a smaller arm.
ELBOW_LAW = {
    "static": 0.11257,
    "stribeck_fall": -0.05719,
    "viscous": 5.7e-4,
    "viscous_bend": -5.4e-7,
    "stribeck_steepness": 3.7748,
}


def machine() -> Robot:
    robot = read_robot("ur5")
    elbow = robot.joint("elbow_joint")
    term = FrictionTerm(law="arctan", side="motor", parameters=ELBOW_LAW)
    return robot.with_joint(elbow.model_copy(update={"friction": (term,)}))


@functools.cache
def identified() -> Identification:
    robot = machine()
    plan = plan_passes(robot, ["elbow_joint"], count=9)
    columns = simulate(robot, plan.trajectory, recorder=Recorder(250.0), seed=1)
    return identify_log(log_from_table(pa.table(columns), "passes"), read_robot("ur5"), law="arctan", side="motor")


@pytest.mark.deep
def test_the_law_behind_the_passes_is_recovered_on_the_motor_side() -> None:
    (law,) = identified().laws
    assert law.joint == "elbow_joint"
    assert law.how == "forward and backward passes"
    values = {fitted.name: fitted.value for fitted in law.parameters}
    # τ_s and τ_sc are known together (past δv = 10 only τ_s + π/2·τ_sc is left), so that the curve is compared.
    speed = np.geomspace(1.0, 100.0, 50)
    truth, found = (
        ARCTAN.along(speed, ambient(speed.size), ARCTAN.pack(v)) for v in (ELBOW_LAW, {**values, "sign_sharpness": 1e9})
    )
    np.testing.assert_allclose(found, truth, rtol=0.02)


@pytest.mark.deep
def test_both_procedures_are_reported() -> None:
    found = identified()
    (law,), (entry,) = found.laws, make_identified_report(found).identified
    assert law.by_slope is not None
    assert entry.by_slope == law.by_slope.values
    assert set(entry.by_slope) >= set(ELBOW_LAW)
    assert {fitted.name: fitted.value for fitted in entry.parameters} == pytest.approx(law.fit.told)
    page = identified_html(found, make_identified_report(found))
    assert "By the slope near zero" in page
    assert f"stribeck_steepness {law.by_slope.values['stribeck_steepness']:.4g}" in page


@pytest.mark.deep
def test_gravity_cancels_between_the_directions() -> None:
    (law,) = identified().laws
    points = law.passes
    assert points is not None
    truth = ARCTAN.along(points.speed * 101.0, ambient(points.speed.size), ARCTAN.pack(ELBOW_LAW)) * 101.0
    np.testing.assert_allclose(points.friction, truth, rtol=0.01)
    assert np.max(np.abs(points.load)) > 0.5 * np.max(points.friction)  # what had to be cancelled
    assert np.all(points.spread < 0.02 * points.friction)


def test_phases_of_constant_speed_are_where_they_were_planned() -> None:
    robot = machine()
    motion = motion_along(robot, plan_passes(robot, ["elbow_joint", "wrist_1_joint"], count=5).trajectory)
    phases = constant_speed_phases(motion)
    for joint in (2, 3):
        speeds = [phase.velocity for phase in phases if phase.joint == joint]
        planned = np.geomspace(0.006, 1.2, 5)
        np.testing.assert_allclose(sorted(v for v in speeds if v > 0.0), planned, rtol=0.02)
        np.testing.assert_allclose(sorted(-v for v in speeds if v < 0.0), planned, rtol=0.02)
    assert {phase.joint for phase in phases} == {2, 3}


def test_a_joint_that_creeps_at_its_rests_makes_no_passes() -> None:
    # As one does that MuJoCo's dry friction holds, in a log without noise.
    robot = machine()
    planned = plan_passes(robot, ["elbow_joint"], count=5).trajectory
    away = np.where(np.arange(planned.time.size) < planned.time.size // 2, 1.0, -1.0)[:, None]
    creeping = replace(planned, position=planned.position + 1e-8 * np.cumsum(away, axis=0))
    still, creeps = (constant_speed_phases(motion_along(robot, course)) for course in (planned, creeping))
    assert [phase.joint for phase in creeps] == [phase.joint for phase in still] == [ELBOW] * len(still)


def points_of(values: dict[str, float], speed: np.ndarray, noise: float = 0.0, seed: int = 5) -> FrictionMap:
    friction = ARCTAN.along(speed, ambient(speed.size), ARCTAN.pack(values))
    friction = friction + noise * np.random.default_rng(seed).normal(size=speed.size)
    spread = np.full(speed.size, max(noise, 1e-6))
    return FrictionMap(0, speed, friction, spread, np.zeros(speed.size), np.ones(speed.size))


@pytest.mark.parametrize(
    "published",
    [
        (1.5237, -0.6757, 0.0027, -2.1e-6, 10.0972),
        (1.0419, -0.4026, 0.0120, -1.3e-5, 3.5088),
        (1.1257, -0.5719, 0.0057, -5.4e-6, 3.7748),
        (0.1623, -0.0581, 0.0012, -1.0e-6, 7.3695),
        (0.5144, -0.1903, 0.0022, -7.7e-7, 3.4900),
        (0.6855, -0.3718, 0.0023, -1.6e-6, 5.4420),
    ],
)
def test_table_1_is_recovered_from_its_own_curves(published: tuple[float, ...]) -> None:
    names = ("static", "stribeck_fall", "viscous", "viscous_bend", "stribeck_steepness")
    truth = dict(zip(names, published, strict=True))
    points = points_of(truth, np.geomspace(0.05, 400.0, 30))
    found = fit_map(points, ARCTAN, "joint", 1.0)
    for name in names:
        assert found.values[name] == pytest.approx(truth[name], rel=1e-3)


def test_the_papers_own_procedure_comes_near_where_slow_speeds_were_recorded() -> None:
    names = ("static", "stribeck_fall", "viscous", "viscous_bend", "stribeck_steepness")
    truth = dict(zip(names, (1.0419, -0.4026, 0.0120, -1.3e-5, 3.5088), strict=True))
    points = points_of(truth, np.geomspace(0.02, 400.0, 40))
    by_slope, least_squares = arctan_procedure(points, "joint", 1.0), fit_map(points, ARCTAN, "joint", 1.0)
    # The rough τ_sc holds a π/2 too much, so that δ comes out too small by about as much; least squares does not.
    assert 0.5 < by_slope.values["stribeck_steepness"] / truth["stribeck_steepness"] < 0.8
    assert by_slope.rms < 0.05
    assert least_squares.rms < 1e-3 * by_slope.rms


@pytest.mark.deep
def test_half_widths_of_a_map_hold_the_truth() -> None:
    names = ("static", "stribeck_fall", "viscous", "viscous_bend", "stribeck_steepness")
    truth = dict(zip(names, (1.0419, -0.4026, 0.0120, -1.3e-5, 3.5088), strict=True))
    speeds = np.geomspace(0.05, 400.0, 40)
    fits = [fit_map(points_of(truth, speeds, noise=0.01, seed=seed), ARCTAN, "joint", 1.0) for seed in range(12)]
    inside = [abs(found.values[name] - truth[name]) < found.half[name] for found in fits for name in names]
    assert np.mean(inside) >= 0.9
    for name in names:
        spread = float(np.std([found.values[name] for found in fits]))
        # Twice as wide as the truth scatters would hold it too, and be of no use.
        assert np.median([found.half[name] for found in fits]) < 2.0 * 2.0 * spread, name


def test_too_few_speeds_and_curves_that_do_not_fall_are_refused() -> None:
    rising = FrictionMap(0, *np.array([[0.1, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0], [1.0, 2, 3, 4, 5, 6, 7]]), *np.ones((3, 7)))
    with pytest.raises(LogError, match="does not fall"):
        arctan_procedure(rising, "joint", 1.0)
    few = FrictionMap(0, *np.ones((5, 4)))
    with pytest.raises(LogError, match="record at least 6 speeds"):
        fit_map(few, STRIBECK, "joint", 1.0)


@pytest.mark.parametrize(
    ("joint", "kind"),
    [(0, GravityClass.NEVER), (1, GravityClass.ALWAYS), (4, GravityClass.BY_POSE), (5, GravityClass.BY_POSE)],
)
def test_a_pose_free_of_gravity_is_free_of_it(joint: int, kind: GravityClass) -> None:
    body = read_robot("ur5").body()
    found = gravity_pose(body, joint)
    assert found.kind is kind
    poses = np.tile(found.pose, (20, 1))
    poses[:, joint] = np.linspace(-2.0, 2.0, 20)
    felt = inverse_dynamics(body, poses, 0.0 * poses, 0.0 * poses)[:, joint]
    free = np.max(np.abs(felt)) < 0.02
    assert free == (kind is not GravityClass.ALWAYS)


def test_excitation_stays_within_limits_and_tells_more_than_the_first_draw() -> None:
    robot = read_robot("z1")
    body = robot.body()
    plan = plan_excitation(robot, 20.0)
    position = plan.trajectory.position
    assert np.all(position >= body.lower - 1e-9)
    assert np.all(position <= body.upper + 1e-9)
    middle, reach = room(body)
    top = np.minimum(body.top_speed, UNSTATED_SPEED)
    draws = [excitation(robot.joints, middle, reach, top, 20.0, seed=seed) for seed in range(DRAWS)]
    told = [least_told(body, motion_along(robot, draw)) for draw in draws]
    assert least_told(body, motion_along(robot, plan.trajectory)) == pytest.approx(max(told))
    assert max(told) > 1.2 * min(told)


def test_separation_names_where_two_models_differ_most() -> None:
    robot = read_robot("ur5")
    wrist = robot.joint("wrist_2_joint")
    stiffer = robot.with_joint(wrist.model_copy(update={"spring": wrist.spring.model_copy(update={"stiffness": 5.0})}))
    (words,) = plan_separation((robot, stiffer)).words
    assert "wrist_2_joint" in words
    with pytest.raises(RobotError, match="predict the same"):
        plan_separation((robot, robot))


def test_plans_refuse_what_they_cannot_do() -> None:
    robot = read_robot("ur5")
    with pytest.raises(RobotError, match="no joint 'elbow'"):
        plan_passes(robot, ["elbow"])
    with pytest.raises(RobotError, match="at least 3"):
        plan_passes(robot, ["elbow_joint"], count=2)
    with pytest.raises(RobotError, match="cannot pass over 9 rad"):
        plan_passes(robot, ["elbow_joint"], stroke=9.0)
    with pytest.raises(RobotError, match=r"cannot pass at 0\.5 to 0\.2 rad/s"):
        plan_passes(robot, ["elbow_joint"], slowest=0.5, fastest=0.2)
    with pytest.raises(RobotError, match="not above its limit"):
        plan_passes(robot, ["elbow_joint"], fastest=50.0)


def test_passes_keep_to_the_speeds_and_the_stroke_that_were_asked_for() -> None:
    robot = read_robot("ur5")
    plan = plan_passes(robot, ["elbow_joint"], count=4, slowest=0.1, fastest=0.8, stroke=0.6)
    motion = motion_along(robot, plan.trajectory)
    phases = [phase for phase in constant_speed_phases(motion) if phase.joint == 2]
    speeds = np.array(sorted({round(abs(phase.velocity), 2) for phase in phases}))
    assert speeds == pytest.approx([0.1, 0.2, 0.4, 0.8], rel=0.03)
    assert np.ptp(plan.trajectory.position[:, 2]) == pytest.approx(0.6, rel=1e-3)


def test_measured_gap_of_the_identified_robot_is_smaller() -> None:
    found = identified()
    after = measure_gap(found.gap.log, found.robot)
    elbow = found.gap.robot.joints.index("elbow_joint")
    assert after.rms(after.residual[:, elbow], elbow) < 0.05 * found.gap.rms(found.gap.residual[:, elbow], elbow)


def test_what_the_robot_file_states_besides_is_not_taken_for_friction() -> None:
    # A drive that reports 30 % too much, and friction that varies along the stroke, both stated.
    elbow = machine().joint("elbow_joint")
    wave = {"wavenumber": 6.0, "cosine": 1.0, "sine": 0.0}
    sensor = elbow.effort_sensor.model_copy(update={"scale": 1.3})
    plain = FrictionTerm(law="coulomb_viscous", parameters={"coulomb": 7.0, "viscous": 8.0})
    table = elbow.model_dump() | {"friction_waves": [wave], "effort_sensor": sensor.model_dump(), "friction": [plain]}
    robot = machine().with_joint(type(elbow).model_validate(table))
    plan = plan_passes(robot, ["elbow_joint"], count=5)
    columns = simulate(robot, plan.trajectory, recorder=Recorder(250.0), seed=1)
    found = identify_log(log_from_table(pa.table(columns), "passes"), robot, law="coulomb_viscous")
    (law,) = found.laws
    values = {fitted.name: fitted.value for fitted in law.parameters}
    assert law.how == "forward and backward passes"
    assert values["coulomb"] == pytest.approx(7.0, rel=0.01)
    assert values["viscous"] == pytest.approx(8.0, rel=0.01)
    # What is said of the robot is so of the robot that is written.
    (error,) = (error for error in found.joints if error.joint == "elbow_joint")
    assert error.rms_heldout_after == pytest.approx(error.rms_after, rel=1e-6)


def test_a_robot_of_one_joint_and_one_without_gravity_can_be_planned_for() -> None:
    assert plan_passes(read_robot("linear_axis"), read_robot("linear_axis").joints, count=4).trajectory.time.size > 100
    arm = read_robot("ur5")
    floating = Robot(arm.table.model_copy(update={"gravity": (0.0, 0.0, 0.0)}), arm.folder)
    assert gravity_pose(floating.body(), 1).kind is GravityClass.NEVER


def test_a_slow_axis_is_planned_for_at_its_own_speeds() -> None:
    table = read_robot("machine_table")
    plan = plan_passes(table, ["axis"], count=5)
    speed = np.abs(np.gradient(plan.trajectory.position[:, 0], plan.trajectory.time))
    assert np.max(speed) == pytest.approx(0.8 * 0.5, rel=0.02)  # of the 0.5 m/s that the robot file states
    assert np.max(np.abs(plan.trajectory.position)) <= 0.25
    assert "m/s" in plan.words[0]


@pytest.mark.deep
def test_joints_that_are_held_while_one_passes_are_not_identified() -> None:
    # The others' drives take hold with a start and then give by what the elbow makes them: no motion of their own.
    robot = read_robot("ur5")
    plan = plan_passes(robot, ["elbow_joint"], count=6)
    columns = simulate(robot, plan.trajectory, recorder=Recorder(250.0), seed=1)
    assert np.ptp(columns["position.shoulder_lift_joint"]) > 0.0
    found = identify_log(log_from_table(pa.table(columns), "passes"), robot)
    assert [law.joint for law in found.laws] == ["elbow_joint"]
    (law,) = found.laws
    # Nothing is recorded with noise: what a richer law explains is a trace.
    assert law.fit.law.name == "coulomb_viscous"
    assert law.how == "forward and backward passes"
    rest = {name for name in found.robot.joints if name != "elbow_joint"}
    assert all(found.robot.joint(name).friction == robot.joint(name).friction for name in rest)


@pytest.mark.deep
def test_passes_that_cannot_tell_a_law_say_why() -> None:
    robot = read_robot("ur5")
    plan = plan_passes(robot, ["elbow_joint"], count=5)
    columns = simulate(robot, plan.trajectory, recorder=Recorder(250.0), seed=1)
    log = log_from_table(pa.table(columns), "passes")
    (law,) = identify_log(log, robot, law="stribeck").laws
    assert law.how == "free motion; 5 speeds were steady both ways, stribeck needs 6"
    (law,) = identify_log(log, robot, law="asymmetric").laws
    assert law.how == "free motion; the passes' differences do not tell asymmetric"


def one_by_one(parts: list[np.ndarray]) -> Identification:
    """Identify a UR5 whose joints wait for the elbow, and the elbow for the others, from parts (n, joints)."""
    robot = read_robot("ur5")
    motion = joined(robot.joints, parts, robot.body())
    log = log_from_table(pa.table(simulate(robot, motion, recorder=Recorder(250.0), seed=1)), "log")
    return identify_log(log, robot, law="coulomb_viscous")


def elbow(course: np.ndarray) -> np.ndarray:
    pose = np.tile(np.array([0.0, -1.2, 1.0, -0.4, 1.2, 0.0]), (course.size, 1))
    pose[:, 2] += course
    return pose


def test_passes_one_way_only_are_named() -> None:
    onward = [trapezoid(0.8, speed, 2.0) for speed in (0.1, 0.2, 0.4, 0.7)]
    # Back by smooth moves, which have no phase of constant speed.
    law = one_by_one([elbow(course) for course in onward]).laws[0]
    assert law.joint == "elbow_joint"
    assert "record the same speeds in the other direction" in law.how


@pytest.mark.deep
def test_a_joint_that_moves_alone_but_never_steadily_is_told_what_to_record() -> None:
    time = np.arange(0.0, 20.0, 1.0 / 250.0)
    law = one_by_one([elbow(0.6 * np.sin(0.9 * time))]).laws[0]
    assert law.how.startswith("free motion; it moves alone, but nowhere at a constant speed")
    assert "plan --protocol forward_backward" in law.how


@pytest.mark.deep
def test_free_motion_of_all_joints_was_not_meant_for_passes() -> None:
    time = np.arange(0.0, 15.0, 1.0 / 250.0)[:, None]
    swing = 0.4 * np.sin(time * np.array([0.9, 1.1, 1.3, 1.0, 1.2, 0.8])) + elbow(np.zeros(1))
    assert {law.how for law in one_by_one([swing]).laws} == {"free motion"}


@pytest.mark.parametrize(
    ("truth", "values"),
    [
        ("coulomb_viscous", {"coulomb": 5.0, "viscous": 3.0}),
        (
            "stribeck",
            {"coulomb": 5.0, "static": 7.0, "stribeck_velocity": 0.05, "stribeck_exponent": 1.0, "viscous": 3.0},
        ),
    ],
)
def test_passes_say_which_law_they_need(truth: str, values: dict[str, float]) -> None:
    law, speed = find_law(truth), np.geomspace(0.005, 1.0, 14)
    right = []
    for seed in range(5):
        noise = 0.02 * np.random.default_rng(seed).normal(size=speed.size)
        friction = law.along(speed, ambient(speed.size), law.pack(values)) * (1.0 + noise)
        points = FrictionMap(0, speed, friction, 0.1 * friction, np.zeros(speed.size), np.full(speed.size, 25.0))
        laws = [find_law(name) for name in ("coulomb_viscous", "quadratic_viscous", "saturating_viscous", "stribeck")]
        right.append(choose_on_map(points, laws, "joint", 1.0)[0].law is law)
    assert all(right)


@pytest.mark.deep
def test_joints_that_rest_while_another_passes_do_not_bend_links_and_zeros() -> None:
    # At rest friction may be anything within its level, and most of such a log is rest.
    robot = read_robot("ur5")
    plan = plan_passes(robot, ["shoulder_lift_joint", "elbow_joint"], count=4)
    columns = simulate(robot, plan.trajectory, recorder=Recorder(125.0), seed=1)
    found = identify_log(log_from_table(pa.table(columns), "passes"), robot, law="coulomb_viscous")
    assert {error.joint for error in found.joints} == {"shoulder_lift_joint", "elbow_joint"}
    for error in found.joints:
        assert error.rms_heldout_after < 1.5 * error.rms_before  # the robot was stated exactly


@pytest.mark.deep
def test_passes_both_ways_need_no_pendulum() -> None:
    # Links are heavier than stated: with the stated model's gravity, friction forward is not friction backward.
    stated = read_robot("ur5")
    scales = {"elbow_joint": 1.05, "wrist_1_joint": 1.05}
    heavier = Robot(stated.table.model_copy(update={"link_scale": scales}), stated.folder)
    plan = plan_passes(stated, ["shoulder_lift_joint"], count=5)
    columns = simulate(heavier, plan.trajectory, recorder=Recorder(250.0), controller_robot=stated, seed=1)
    log = log_from_table(pa.table(columns), "passes")
    found = identify_log(log, stated, law="coulomb_viscous")
    (law,) = (law for law in found.laws if law.joint == "shoulder_lift_joint")
    assert law.pendulum is not None
    assert law.passes is not None
    by_model, by_fit = law.pendulum.apart
    (truth,) = stated.joint("shoulder_lift_joint").friction or ()
    true_friction = truth.value("coulomb") + truth.value("viscous") * law.passes.speed
    by_both = np.sqrt(np.mean(np.square(law.passes.friction - true_friction)))
    entry = next(entry for entry in make_identified_report(found).identified if entry.joint == law.joint)
    assert entry.apart_by_pendulum == pytest.approx((by_model, by_fit))
    assert f"{by_model:.4g} N·m to either side" in identified_html(found, make_identified_report(found))
    assert by_model > 1.0
    assert by_fit < 0.2 * by_model
    assert by_both < 0.05 * by_model
