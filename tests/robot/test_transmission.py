"""Where a link is behind its motor: against a fall from stop to stop, and against the machine in MuJoCo."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pyarrow as pa
import pytest

from mjfriction.control.servo import Control
from mjfriction.plant.machine import log_columns, run_machine
from mjfriction.plant.motions import excitation, forward_backward
from mjfriction.plant.sensors import Recorder
from mjfriction.record.log import Floats
from mjfriction.record.motion import Motion, estimate_motion
from mjfriction.record.readers.table import log_from_table
from mjfriction.robot import transmission
from mjfriction.robot.effort import link_motion, without_offsets
from mjfriction.robot.files import read_robot
from mjfriction.robot.own_slopes import Slopes, own_slopes
from mjfriction.robot.schema import Transmission
from mjfriction.sim.lagging import Lagging
from mjfriction.sim.stops import between_stops
from tests.deep import deep

HOME = np.array([0.0, -1.2, 1.4, -0.4, 1.2, 0.0])
UPRIGHT = np.array([0.0, -1.57, 0.0, -1.57, 0.0, 0.0])


def test_between_its_stops_a_mass_falls_through_its_drag() -> None:
    step, pull, drag = 1e-4, 8.0, 6.0
    time = np.arange(3000) * step
    pulls = np.where(time < 0.5 * step, -pull, pull)
    place = between_stops(pulls, np.zeros(time.size), step, 0, 1, np.full(time.size, drag))
    exact = pull / drag * (time - (1.0 - np.exp(-drag * time)) / drag) - 1.0
    np.testing.assert_allclose(place, exact, atol=2e-3)
    assert np.max(np.abs(between_stops(pulls, np.zeros(time.size), step, 0) - exact)) > 0.05


def test_between_its_stops_a_mass_falls_freely() -> None:
    step, pull = 1e-4, 8.0
    time = np.arange(20000) * step
    place = between_stops(np.where(time < 0.5, -pull, pull), np.zeros(time.size), step, 10)
    assert np.all(place[time < 0.5] == -1.0)
    landing = 0.5 + np.sqrt(2.0 * 2.0 / pull)
    free = (time >= 0.5) & (time < landing - step)
    np.testing.assert_allclose(place[free], -1.0 + 0.5 * pull * (time[free] - 0.5) ** 2, atol=2e-3)
    assert np.all(place[time > landing + step] == 1.0)


def test_between_its_stops_a_mass_on_a_spring_swings() -> None:
    step, frequency = 1e-4, 6.0
    time = np.arange(9000) * step
    pull = np.where(time < 0.1, -2.0, -0.4) * frequency**2
    place = between_stops(pull, np.full(time.size, frequency**2), step, 0)
    free = time >= 0.1
    np.testing.assert_allclose(place[free], -0.4 - 0.6 * np.cos(frequency * (time[free] - 0.1)), atol=2e-3)


def test_what_pulls_a_mass_on_holds_it_beyond_the_middle() -> None:
    """A link that stands: the pull has to turn by what its fall brings before it lets go, either way."""
    step, time = 1e-3, np.arange(40000) * 1e-3
    pull = 100.0 * np.sin(0.25 * time)
    place = between_stops(pull, np.full(time.size, -30.0), step, 0)
    let_go = np.flatnonzero((np.abs(place[:-1]) == 1.0) & (np.abs(place[1:]) < 1.0))
    assert let_go.size > 2
    np.testing.assert_allclose(-pull[let_go] * place[let_go], 30.0, atol=0.1)


def test_a_pull_given_at_fewer_points_is_followed_in_finer_steps() -> None:
    step, finer = 1e-3, 4
    coarse = 30.0 * np.sin(np.arange(300) * step * finer * 9.0)
    fine = np.interp(np.arange(299 * finer + 1) / finer, np.arange(300), coarse)
    expected = between_stops(fine, 0.0 * fine, step, 10)[::finer]
    np.testing.assert_allclose(between_stops(coarse, 0.0 * coarse, step, 10, finer), expected, atol=1e-9)


def test_a_stop_keeps_what_it_caught_while_the_blow_rings() -> None:
    step = 1e-3
    pull = np.full(1000, 50.0)
    pull[0] = -1.0
    landed = int(np.argmax(between_stops(pull, 0.0 * pull, step, 0) == 1.0))
    pull[landed + 1 : landed + 15] = -2000.0  # what a filter leaves of the blow
    assert np.min(between_stops(pull, 0.0 * pull, step, 0)[landed:]) < 0.9
    assert np.all(between_stops(pull, 0.0 * pull, step, 20)[landed:] == 1.0)


def followed(pull: np.ndarray, back: float, step: float, caught: int, finer: int) -> list[float]:
    """Return where the mass is, every step taken, those too at which a stop holds it."""
    place, speed, held, before = float(np.sign(pull[0])), 0.0, 0, float(pull[0])
    stop, out = place, []
    for k, now in enumerate(pull.tolist()):
        for part in range(1 if k > 0 else finer, finer + 1):
            held -= 1
            if held <= 0:
                speed += (before + (now - before) / finer * part - back * place) * step
                place += speed * step
            if abs(place) >= 1.0:
                place, speed = float(np.sign(place)), 0.0
                if place != stop:
                    stop, held = place, caught
        before = now
        out.append(place)
    return out


@pytest.mark.parametrize("size", [1e3, 1e5, 1e7])
@pytest.mark.parametrize(("caught", "finer"), [(0, 1), (20, 5)])
@pytest.mark.parametrize("share", [0.0, 0.3, -0.3])
def test_a_mass_on_its_stop_stays_there_until_the_pull_turns(
    size: float, caught: int, finer: int, share: float
) -> None:
    rng, time = np.random.default_rng(0), np.arange(1500)
    pull = size * (np.sin(0.02 * time) + 0.3 * rng.normal(size=time.size))
    place = between_stops(pull, np.full(pull.size, share * size), 1e-3, caught, finer)
    np.testing.assert_array_equal(place, followed(pull, share * size, 1e-3, caught, finer))
    assert {-1.0, 1.0} <= set(place.tolist())


@pytest.mark.parametrize(
    ("joint", "play", "home", "speed"),
    # Fast enough for gravity to be overcome, or slowly past the upright, so that both stops are reached.
    [
        ("shoulder_lift_joint", 0.04, HOME, 2.5),
        deep("wrist_2_joint", 0.02, HOME, 2.5),
        deep("shoulder_lift_joint", 0.08, UPRIGHT, 0.1),
    ],
)
def test_the_link_is_where_the_machine_has_it(joint: str, play: float, home: np.ndarray, speed: float) -> None:
    robot = read_robot("ur5")
    i = robot.joints.index(joint)
    loose = robot.with_joint(robot.table.joint[i].model_copy(update={"transmission": Transmission(backlash=play)}))
    course = excitation(robot.joints, home, np.full(6, 0.3 + 0.2 * speed), np.full(6, speed), 12.0, seed=3)
    recorder = Recorder(500.0)
    run = run_machine(loose, course, recorder.rate, Control())
    log = log_from_table(pa.table(log_columns(loose, course, recorder, run, 0)), "log")
    motion = estimate_motion(log, loose.joints, 40.0)
    body = loose.body()
    linked = link_motion(loose, body, without_offsets(loose, motion))
    predicted = (motion.position - linked.position)[:, i] / (0.5 * play)
    place = np.interp(motion.time, run.time, (run.played.position - run.played.link_position)[:, i]) / (0.5 * play)
    inner = (motion.time > 1.0) & (motion.time < 11.0)
    assert np.min(place[inner]) < -0.9
    assert np.max(place[inner]) > 0.9
    assert np.sqrt(np.mean(np.square(predicted - place)[inner])) < 0.005


def machine_and_motion(
    own: Transmission, joint: int = 0, speed: float = 2.0
) -> tuple[Floats, Motion, Callable[..., float]]:
    """A UR5 with a link on a transmission: how far the link lags in MuJoCo, the motion that its log shows, and how much
    of that lag a transmission misses, relative to its deviation.
    """
    robot = read_robot("ur5")
    soft = robot.with_joint(robot.table.joint[joint].model_copy(update={"transmission": own}))
    course = excitation(robot.joints, HOME, np.full(6, 0.5), np.full(6, speed), 8.0, seed=3)
    recorder = Recorder(500.0)
    run = run_machine(soft, course, recorder.rate, Control())
    log = log_from_table(pa.table(log_columns(soft, course, recorder, run, 0)), "log")
    motion = estimate_motion(log, soft.joints, 40.0)
    lag = np.interp(motion.time, run.time, (run.played.position - run.played.link_position)[:, joint])
    inner = (motion.time > 1.0) & (motion.time < 7.0)

    def missed(told_of: Transmission, slopes: Slopes = own_slopes) -> float:
        told = robot.with_joint(robot.table.joint[joint].model_copy(update={"transmission": told_of}))
        linked = link_motion(told, told.body(), without_offsets(told, motion), slopes)
        return float(np.std(((motion.position - linked.position)[:, joint] - lag)[inner]) / np.std(lag[inner]))

    return lag[inner], motion, missed


def test_a_lightly_damped_link_that_bears_its_weight_is_where_the_machine_has_it() -> None:
    """Its weight changes as it sags: it swings at another frequency than on its spring alone."""
    soft = Transmission(compliance=1e-3, damping_ratio=0.02)
    _, _, missed = machine_and_motion(soft, 1, 1.5)
    right = missed(soft)
    assert right < 0.001
    weightless = np.array([0.0, 1.0, 1.0])[:, None, None]
    assert missed(soft, lambda body, motion: own_slopes(body, motion) * weightless) > 30.0 * right


def test_a_link_that_outweighs_its_spring_does_not_run_away() -> None:
    """No such machine stands; but a robot file can state one."""
    time, spring = np.arange(0.0, 20.0, 4e-3), 50.0
    columns = {"time": time, "position.axis": np.sin(time)}
    motion = estimate_motion(log_from_table(pa.table(columns), "log"), ("axis",), 20.0)
    one = np.ones_like(motion.time)
    link = Lagging(np.sin(5.0 * motion.time), one, -2.0 * spring * one, 0.0 * one)
    place = transmission.swinging(motion, link, spring, 1.0)
    assert 1.0 / spring < np.max(np.abs(place)) < 100.0 / spring


def test_how_a_link_swings_where_a_log_begins_is_told_from_the_effort() -> None:
    """It begins amid a stroke, and the link still swings from its start; without efforts, nobody can know."""
    soft, begins = Transmission(compliance=1e-3, damping_ratio=0.02), 4.2
    robot = read_robot("ur5")
    machine = robot.with_joint(robot.table.joint[0].model_copy(update={"transmission": soft}))
    course, recorder = forward_backward("shoulder_pan_joint", -0.8, 1.6, [0.5, 0.5], 4.0), Recorder(500.0)
    run = run_machine(machine, course, recorder.rate, Control(), robot)
    log = log_from_table(pa.table(log_columns(machine, course, recorder, run, 0)).slice(int(500.0 * begins)), "log")
    motion = estimate_motion(log, robot.joints, 40.0)
    lag = np.interp(motion.time, run.time, (run.played.position - run.played.link_position)[:, 0])

    def missed(along: Motion) -> float:
        linked = link_motion(machine, machine.body(), without_offsets(machine, along))
        return float(np.std((along.position - linked.position)[:, 0] - lag))

    assert abs(motion.velocity[0, 0]) > 0.4
    assert missed(motion) < 0.05 * np.std(lag)
    assert missed(replace(motion, torque=np.full_like(motion.torque, np.nan))) > 5.0 * missed(motion)


def test_a_link_on_a_spring_that_hardens_is_where_the_machine_has_it() -> None:
    springs = Transmission(compliance=3e-3, hardening=2e7, damping_ratio=0.1)
    lag, motion, missed = machine_and_motion(springs)
    assert springs.hardening * springs.compliance * np.max(lag) ** 2 > 0.5
    assert missed(springs) < 0.03
    assert missed(springs.model_copy(update={"hardening": 0.0})) > 0.2
    # Without a damping ratio it follows its load at once, and its spring's torque is the load.
    load = 4.0 * motion.acceleration[:, 0]
    held = Lagging(load, np.ones_like(load), np.zeros_like(load), np.zeros_like(load))
    still = springs.model_copy(update={"damping_ratio": None})
    given, straight = (
        transmission.lag(own, motion, load, held) for own in (still, still.model_copy(update={"hardening": 0}))
    )
    assert np.max(straight / given) > 2.0
    np.testing.assert_allclose(given / still.compliance + still.hardening * given**3, straight / still.compliance)


@pytest.mark.parametrize(
    ("flanks", "without"),
    [
        (Transmission(compliance=1e-4, damping_ratio=0.3, backlash=0.006), {"compliance": 0.0}),
        (Transmission(compliance=3e-3, hardening=2e7, damping_ratio=0.2, backlash=0.004), {"hardening": 0.0}),
    ],
)
def test_a_link_between_flanks_that_give_is_where_the_machine_has_it(
    flanks: Transmission, without: dict[str, float]
) -> None:
    _, _, missed = machine_and_motion(flanks)
    right = missed(flanks)
    assert right < 0.1
    for less in ({"backlash": 0.0}, without):
        assert missed(flanks.model_copy(update=less)) > 4.0 * right
