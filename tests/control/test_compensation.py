"""Compensation on machines: friction fed forward by its law, observed, cancelled; what a controller reads."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from mjfriction.control.chattering import chattering
from mjfriction.control.course import Course
from mjfriction.control.disturbance import DisturbanceObserver
from mjfriction.control.feedforward import feedforward_friction
from mjfriction.control.friedland import Tafazoli
from mjfriction.control.observe import OBSERVERS
from mjfriction.control.observer import Observer
from mjfriction.control.sensing import Sensing
from mjfriction.control.servo import Control
from mjfriction.control.valve import FrictionSource, ValveControl, ValveGains
from mjfriction.errors import ControlError
from mjfriction.laws.ambient import ambient
from mjfriction.laws.catalog import LAWS
from mjfriction.laws.portrait import typical_values
from mjfriction.plant.machine import Run, run_machine
from mjfriction.plant.motions import inner_loops, sine
from mjfriction.plant.trajectory import Trajectory
from mjfriction.robot.files import read_robot
from mjfriction.robot.friction_tables import FrictionTerm
from mjfriction.robot.robot import Robot


@pytest.fixture(scope="module")
def table() -> Robot:
    return read_robot("machine_table")


def observer(mass: float, step: float) -> DisturbanceObserver:
    return DisturbanceObserver.with_bandwidth(mass, step, 4.0)


def error(done: Run, joint: int = 0) -> float:
    # Past the first half: the laws have met their reversals.
    half = done.time.size // 2
    return float(np.ptp((done.wanted - done.played.position)[half:, joint]))


def followed(table: Robot, control: Control, period: float = 8.0) -> Run:
    return run_machine(table, inner_loops("axis", 0.0, 80e-6, period), 1000.0, control, table)


@pytest.mark.deep
def test_fed_forward_or_observed_friction_makes_the_error_small_and_both_beat_either(table: Robot) -> None:
    plain = Control(bandwidth=20.0, friction="none", cancels_cogging=True, sensed=True)
    none = error(followed(table, plain))
    law = error(followed(table, Control(**{**vars(plain), "friction": "law"})))
    seen = error(followed(table, Control(**{**vars(plain), "observer": observer})))
    both = error(followed(table, Control(**{**vars(plain), "friction": "law", "observer": observer})))
    assert none > 30e-6
    assert law < 0.1 * none
    assert seen < 0.25 * none
    assert both < min(law, seen)


def test_an_observer_loses_at_ten_times_the_speed(table: Robot) -> None:
    control = Control(bandwidth=20.0, friction="none", cancels_cogging=True, sensed=True, observer=observer)
    assert error(followed(table, control, 0.8)) > 3.0 * error(followed(table, control))


def test_what_an_observer_adds_is_the_friction_that_acts(table: Robot) -> None:
    control = Control(bandwidth=20.0, friction="none", cancels_cogging=True, observer=observer)
    done = followed(table, control)
    late = done.time > 2.0
    left = np.sqrt(np.mean(np.square((done.estimates - done.played.friction)[late, 0])))
    assert left < 0.1 * np.sqrt(np.mean(np.square(done.played.friction[late, 0])))


def test_cogging_that_is_known_is_cancelled_at_the_place_read(table: Robot) -> None:
    # Past friction what is left of the error over a slow stroke is cogging's waves.
    course = sine("axis", 0.0, 0.02, 0.25, 2.0)
    control = Control(bandwidth=15.0, friction="law")
    kept = run_machine(table, course, 1000.0, control, table)
    cancelled = run_machine(table, course, 1000.0, Control(**{**vars(control), "cancels_cogging": True}), table)
    middle = (kept.time > 3.0) & (kept.time < 5.0)
    sizes = [np.std((done.wanted - done.played.position)[middle, 0]) for done in (kept, cancelled)]
    assert sizes[1] < 0.2 * sizes[0]


def test_friction_fed_forward_is_the_law_along_the_wanted_motion(table: Robot) -> None:
    step = 1e-3
    time = np.arange(0.0, 2.0, step)
    place = 1e-4 * np.sin(np.pi * time)
    course = Course(*(values[:, None] for values in (place, np.gradient(place, step), 0.0 * time)))
    fed = feedforward_friction(table, "law", course, step)
    (term,) = table.table.joint[0].friction or ()
    own, _ = term.friction(1.0).follow(course.velocity[:, 0], ambient(time.size, position=place), step)
    assert np.array_equal(fed[:, 0], own)
    assert not np.any(feedforward_friction(table, "none", course, step))


@pytest.mark.parametrize("name", LAWS)
def test_every_law_is_fed_forward_as_it_rubs(table: Robot, name: str) -> None:
    # The same law in the machine: what was fed forward along the wanted motion is what then rubs along the real one,
    # so that the slide follows as one without friction does.
    term = FrictionTerm(law=name, parameters=typical_values(LAWS[name]))
    slide = table.joint("axis").model_copy(update={"cogging": (), "friction": ()})
    smooth = table.with_joint(slide)
    rubbed = table.with_joint(slide.model_copy(update={"friction": (term,)}))
    course = sine("axis", 0.0, 0.05, 0.5, 2.0)

    def followed_by(machine: Robot, what: str) -> Run:
        return run_machine(machine, course, 1000.0, Control(bandwidth=20.0, friction=what), machine)

    free, fed, none = followed_by(smooth, "none"), followed_by(rubbed, "law"), followed_by(rubbed, "none")
    left, whole = (np.std((done.played.position - free.played.position)[:, 0]) for done in (fed, none))
    assert left < 0.2 * whole


@pytest.mark.parametrize("name", [name for name in OBSERVERS if name != "balance"])
def test_every_observer_works_live_at_every_joint_of_an_arm(name: str) -> None:
    arm = read_robot("ur5")
    for joint in arm.table.joint:
        (term,) = joint.friction or ()
        level = {"coulomb": term.value("coulomb"), "viscous": term.value("viscous")}
        bristle = {"bristle_stiffness": 1e3 * level["coulomb"], "shape_exponent": 1.0}
        dahl = FrictionTerm(law="dahl", parameters={**level, **bristle})
        arm = arm.with_joint(joint.model_copy(update={"friction": (dahl,)}))
    time = np.arange(0.0, 6.0, 0.004)
    swell = np.clip(np.minimum(time, 6.0 - time), 0.0, 1.0) ** 2
    phases = 2.0 * np.pi * (0.25 * time[:, None] + np.arange(6) / 6.0)
    course = Trajectory(arm.joints, time, 0.3 * swell[:, None] * np.sin(phases))
    make, friction = OBSERVERS[name], 60.0  # N·m, more than any of these joints has
    assert make is not None
    places = itertools.cycle(arm.table.joint)

    def observed(mass: float, step: float) -> Observer:
        return make(next(places), mass, step, 2.0 * np.pi * 4.0, friction)

    plain = run_machine(arm, course, 1000.0, Control(bandwidth=8.0, friction="none"), arm)
    with_it = run_machine(arm, course, 1000.0, Control(bandwidth=8.0, friction="none", observer=observed), arm)
    for i in range(6):
        rms = [np.sqrt(np.mean(np.square(done.wanted - done.played.position)[:, i])) for done in (plain, with_it)]
        assert rms[1] < 0.7 * rms[0], arm.joints[i]


def test_six_axes_follow_better_with_levels_with_laws_and_with_observers() -> None:
    arm = read_robot("comau_ns12")
    time = np.arange(0.0, 6.0, 0.004)
    swell = np.clip(np.minimum(time, 6.0 - time), 0.0, 1.0) ** 2
    place = 0.05 * swell[:, None] * np.sin(2.0 * np.pi * (0.25 * time[:, None] + np.arange(6) / 6.0))
    course = Trajectory(arm.joints, time, place)

    def rms(control: Control) -> np.ndarray:
        done = run_machine(arm, course, 1000.0, control, arm)
        return np.sqrt(np.mean(np.square(done.wanted - done.played.position), axis=0))

    def of_arm(mass: float, step: float) -> DisturbanceObserver:
        return DisturbanceObserver.with_bandwidth(mass, step, 6.0)

    none = rms(Control(bandwidth=20.0, friction="none"))
    stated = rms(Control(bandwidth=20.0, friction="coulomb_viscous"))
    law = rms(Control(bandwidth=20.0, friction="law"))
    seen = rms(Control(bandwidth=20.0, friction="none", observer=of_arm))
    # The last joint's friction falls by five sixths as it breaks away: under so weak a control it hunts, whatever is
    # added.
    assert np.all(stated[:5] < 0.6 * none[:5])
    assert np.all(law[:5] < 0.75 * stated[:5])
    assert np.all(seen[:5] < 0.75 * none[:5])


def test_what_is_sensed_has_the_resolution_and_lags_as_its_low_pass(table: Robot) -> None:
    step = 1e-3
    sensing = Sensing(table, 0, step)
    time = np.arange(0.0, 0.2, step)
    read = [sensing(np.array([0.01 * t]), np.array([0.01])) for t in time]
    place = np.array([values[0][0] for values in read])
    assert np.allclose(place / 1e-8, np.round(place / 1e-8), atol=1e-6)
    assert read[-1][1][0] == pytest.approx(0.01, abs=2e-5)


def test_the_same_seed_reads_the_same(table: Robot) -> None:
    control = Control(bandwidth=20.0, friction="none", sensed=True, observer=observer)
    one, other = (followed(table, control, 1.0).played.position for _ in range(2))
    assert np.array_equal(one, other)


@pytest.fixture(scope="module")
def cylinder() -> Robot:
    return read_robot("hydraulic_cylinder")


def piston(cylinder: Robot, gains: ValveGains, friction: FrictionSource | None = None, *, sensed: bool = False) -> Run:
    control = Control(
        friction="none",
        feedforward="none",
        sensed=sensed,
        valve=ValveControl(gains, gains, friction),  # type: ignore[arg-type]
    )
    return run_machine(cylinder, sine("piston", 0.0, 0.03, 0.5, 2.0), 10000.0, control, cylinder)


def test_a_valve_under_pd_lags_by_its_speed_over_its_gain(cylinder: Robot) -> None:
    soft, hard = (piston(cylinder, ValveGains(gain)) for gain in (1000.0, 4000.0))
    # A valve gives flow: what the position gain asks for is a speed, so that the error is the speed over the gain.
    assert error(soft) == pytest.approx(4.0 * error(hard), rel=0.03)


@pytest.mark.deep
def test_acceleration_fed_back_calms_a_valve_that_is_too_hard(cylinder: Robot) -> None:
    def tafazoli(mass: float, step: float) -> Tafazoli:
        return Tafazoli(mass, 150.0, 300.0)

    wild = piston(cylinder, ValveGains(60000.0), sensed=True)
    calm = piston(cylinder, ValveGains(60000.0, 0.0, 0.1), tafazoli, sensed=True)
    shaken, quiet = (chattering(done.cylinders["piston"].volts, 10000.0, 20.0) for done in (wild, calm))
    assert shaken > 3.0, "without it the valve is in a limit cycle"
    assert quiet < 0.2 * shaken
    assert error(calm) < error(wild)


def test_a_controller_that_knows_the_law_goes_by_the_friction_that_acts(cylinder: Robot) -> None:
    (term,) = cylinder.table.joint[0].friction or ()
    done = piston(cylinder, ValveGains(3000.0), (term.friction(1.0),))
    sliding = np.abs(done.played.velocity[:, 0]) > 0.02
    left = (done.estimates - done.played.friction)[sliding, 0]
    assert np.sqrt(np.mean(np.square(left))) < 0.01 * np.sqrt(np.mean(np.square(done.played.friction[sliding, 0])))


@pytest.mark.parametrize(
    ("wrong", "told"),
    [
        ({"friction": "frction"}, "friction = 'frction' is none of law, coulomb_viscous, none"),
        ({"feedforward": "dynamcs"}, "feedforward = 'dynamcs' is none of .*; did you mean 'dynamics'"),
        ({"bandwidth": -5.0}, "bandwidth = -5 of a controller: allowed is any finite number above 0"),
        ({"damping": float("nan")}, "damping = nan of a controller"),
    ],
)
def test_a_controller_that_is_none_is_refused(wrong: dict[str, object], told: str) -> None:
    with pytest.raises(ControlError, match=told):
        Control(**wrong)  # type: ignore[arg-type]


def test_gains_below_zero_are_refused() -> None:
    with pytest.raises(ControlError, match="valve gain velocity = -1; allowed is 0 or above"):
        ValveGains(1.0, -1.0)
