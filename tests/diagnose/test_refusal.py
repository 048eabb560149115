"""What a model that was found is asked before it is believed, and the noise it is weighed by."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pyarrow as pa
import pytest
from scipy.signal import butter, sosfiltfilt

from mjfriction.diagnose.causes.backlash import Backlash
from mjfriction.diagnose.causes.cause import Site
from mjfriction.diagnose.causes.coupling import SharedMotion
from mjfriction.diagnose.causes.delay import JointDelay, LogDelay
from mjfriction.diagnose.causes.load import Load
from mjfriction.diagnose.causes.presliding import Presliding
from mjfriction.diagnose.causes.stribeck import Stribeck
from mjfriction.diagnose.causes.varying import Step
from mjfriction.diagnose.fit.model import Chosen, Model, build_model, cause_block
from mjfriction.diagnose.fit.nuisance import make_nuisance
from mjfriction.diagnose.fit.trial import try_out
from mjfriction.diagnose.search import compete, refusal
from mjfriction.diagnose.search.field import chances_in, make_field
from mjfriction.diagnose.search.refusal import refused
from mjfriction.diagnose.search.unevenness import with_unevenness
from mjfriction.identify.gap import Gap
from mjfriction.identify.measure import measure_gap
from mjfriction.plant.machine import simulate
from mjfriction.plant.motions import forward_backward
from mjfriction.plant.sensors import Recorder
from mjfriction.progress import silently
from mjfriction.record.load_turns import load_turns
from mjfriction.record.readers import read_log
from mjfriction.record.readers.table import log_from_table
from mjfriction.robot.files import read_robot
from mjfriction.robot.robot import Robot
from tests.diagnose.test_lone_axis import pendulum
from tests.hidden.machine import UR5_COULOMB, UR5_VISCOUS, Instant, Machine, write_case

PAN, SHOULDER, ELBOW = 0, 1, 2


def gap_of_machine(folder: Path, machine: Machine) -> Gap:
    log, robot = write_case(folder, machine, seed=1, seconds=30.0)
    return measure_gap(read_log(log), read_robot(robot))


def late(effort: np.ndarray, instant: Instant, seconds: float) -> np.ndarray:
    return np.interp(instant.time - seconds, instant.time, effort) - effort


def test_a_joint_that_mostly_rests_is_weighed_by_the_noise_of_its_motion(tmp_path: Path) -> None:
    gap = gap_of_machine(tmp_path, Machine())
    level = 300.0 * gap.noise_floor[ELBOW]
    resting = np.sin(2.0 * np.pi * gap.chain.time / 3.0) > -0.6  # two thirds of every three seconds
    held = level * np.sign(gap.at_rows("velocity")[:, ELBOW])  # as far as it can be from what the model takes it for
    doubt, clear, residual = gap.doubt.copy(), gap.clear.copy(), gap.residual.copy()
    doubt[resting, ELBOW], clear[resting, ELBOW] = level, False
    residual[resting, ELBOW] += held[resting]
    model = build_model(replace(gap, doubt=doubt, clear=clear, residual=residual), make_nuisance(gap), ())
    least = 1.0 / float(np.max(model.system.rows.weight[:, ELBOW]))
    assert least == pytest.approx(float(gap.noise_floor[ELBOW]), rel=0.3)


@pytest.mark.parametrize("at_turns", [True, False])
def test_play_is_crossed_where_its_load_turns(*, at_turns: bool, tmp_path: Path) -> None:
    """What looks like play elsewhere is noise of the position, from which the load of a link that hardly has any is
    computed.
    """
    robot = pendulum(tmp_path, "weightless", inertia=0.08, rotor=6e-5, coulomb=0.8)
    robot = Robot(robot.table.model_copy(update={"gravity": (0.0, 0.0, 0.0)}), robot.folder)
    motion = forward_backward("swing", -1.0, 2.0, (0.3, 0.5, 1.5), 6.0)
    columns = simulate(robot, motion, recorder=Recorder(250.0), seed=1)
    columns["position.swing"] = 2e-4 * np.round(columns["position.swing"] / 2e-4)
    gap = measure_gap(log_from_table(pa.table(columns), "swing"), robot)
    crossed = Chosen(Backlash(), Site(0, around=2e-4))
    effort = 2e-4 * cause_block(gap, crossed)[0][0][:, 0]
    turns = load_turns(gap.motion, gap.known.effort.load[:, 0])
    near = np.interp(gap.chain.time, gap.motion.time, turns.near(0.3)) > 0.0
    assert 0.0 < np.mean(near) < 0.5
    shows = near == at_turns
    residual = gap.residual + 40.0 * np.where(shows, effort, 0.0)[:, None]
    # The other rows do not count: a load that seems to turn may have columns as large where it really turns.
    doubt, clear = gap.doubt + np.where(shows, 0.0, 10.0)[:, None], gap.clear & shows[:, None]
    told = replace(gap, residual=residual, doubt=doubt, clear=clear)
    model = build_model(told, make_nuisance(told).without_links(), (crossed,))
    before, after = model.without(crossed).heldout_residual()[:, 0], model.heldout_residual()[:, 0]
    assert told.rms(after, 0) < 0.5 * told.rms(before, 0)
    assert (model.chosen[0] in refused(model)) is not at_turns


@pytest.mark.parametrize("part", ["all", "friction"])
def test_a_delay_of_which_only_friction_knows_is_none(part: str, tmp_path: Path) -> None:
    def hidden(instant: Instant) -> np.ndarray:
        return late(instant.friction + (instant.rigid if part == "all" else 0.0), instant, 0.03)

    gap = gap_of_machine(tmp_path, Machine(hidden={ELBOW: hidden}))
    delay = Chosen(JointDelay(), Site(ELBOW, around=0.03))
    model = build_model(gap, make_nuisance(gap), (delay,))
    assert model.strengths[-1] == pytest.approx(0.03, rel=0.3)
    assert [choice.key for choice in refused(model)] == ([] if part == "all" else [delay.key])


@pytest.mark.parametrize("torn", [(3, 4, 5), (2, 3, 4, 5)])
def test_a_delay_of_all_joints_is_none_where_friction_shows_another_at_most_of_them(
    torn: tuple[int, ...], tmp_path: Path
) -> None:
    def hidden(instant: Instant, joint: int) -> np.ndarray:
        return late(instant.rigid, instant, 0.03) + late(instant.friction, instant, 0.0 if joint in torn else 0.018)

    gap = gap_of_machine(tmp_path, Machine(hidden={joint: partial(hidden, joint=joint) for joint in range(6)}))
    delay = Chosen(LogDelay(), Site(SHOULDER, around=0.03))
    model = build_model(gap, make_nuisance(gap), (delay,))
    assert (delay.key in [choice.key for choice in refused(model)]) is (len(torn) > 3)


def test_joints_that_cannot_tell_do_not_speak_for_a_delay(tmp_path: Path) -> None:
    def hidden(instant: Instant) -> np.ndarray:
        return late(instant.rigid, instant, 0.03)

    bare = (*UR5_COULOMB[:3], 0.0, 0.0, 0.0)
    machine = Machine(hidden=dict.fromkeys(range(6), hidden), coulomb=bare, viscous=(*UR5_VISCOUS[:3], 0.0, 0.0, 0.0))
    log, path = write_case(tmp_path, machine, 1, seconds=30.0)
    robot = read_robot(path)
    for joint in range(3, 6):
        robot = robot.with_joint(robot.table.joint[joint].model_copy(update={"friction": ()}))
    gap = measure_gap(read_log(log), robot)
    delay = Chosen(LogDelay(), Site(SHOULDER, around=0.03))
    assert delay.key in [choice.key for choice in refused(build_model(gap, make_nuisance(gap), (delay,)))]


@pytest.mark.parametrize(("own", "undone"), [(-0.01, True), (0.01, False)])
def test_a_delay_of_all_joints_is_none_where_one_joint_is_on_time(own: float, undone: bool, tmp_path: Path) -> None:
    def hidden(instant: Instant, joint: int) -> np.ndarray:
        return late(instant.rigid + instant.friction, instant, 0.01 + (own if joint == ELBOW else 0.0))

    gap = gap_of_machine(tmp_path, Machine(hidden={joint: partial(hidden, joint=joint) for joint in range(6)}))
    delays = (Chosen(LogDelay(), Site(SHOULDER)), Chosen(JointDelay(), Site(ELBOW)))
    model = build_model(gap, make_nuisance(gap), delays)
    assert model.strengths[-1] == pytest.approx(own, rel=0.2)
    assert (delays[0].key in [choice.key for choice in refused(model)]) is undone


@pytest.mark.parametrize("whole", [True, False])
def test_a_delay_that_only_what_is_quicker_than_the_motion_knows_of_is_none(whole: bool, tmp_path: Path) -> None:
    # The arm shakes, at five times the frequency that it is moved at and above, and its drive answers late.
    inertia, rng = 0.5, np.random.default_rng(1)
    band = butter(2, (3.0, 8.0), btype="band", fs=250.0, output="sos")
    shake = 0.004 * sosfiltfilt(band, rng.normal(size=7500))

    def answer(instant: Instant) -> np.ndarray:
        quick = inertia * np.gradient(np.gradient(shake, instant.time), instant.time)
        return quick + late(quick + (instant.rigid + instant.friction if whole else 0.0), instant, 0.03)

    machine = Machine(sensed={ELBOW: lambda instant: shake}, hidden={ELBOW: answer})
    gap = gap_of_machine(tmp_path, machine)
    delay = Chosen(JointDelay(), Site(ELBOW, around=0.03))
    model = build_model(gap, make_nuisance(gap), (delay,))
    assert model.strengths[-1] > 2.0 * gap.motion.clock.step
    assert (delay.key in [choice.key for choice in refused(model)]) is not whole


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_friction_that_comes_farther_still_does_not_take_a_delay_away(sign: float, tmp_path: Path) -> None:
    def hidden(instant: Instant) -> np.ndarray:
        return late(instant.friction, instant, sign * 0.025) + late(instant.rigid, instant, sign * 0.01)

    gap = gap_of_machine(tmp_path, Machine(hidden={SHOULDER: hidden}))
    delay = Chosen(JointDelay(), Site(SHOULDER))
    model = build_model(gap, make_nuisance(gap), (delay,))
    assert 0.008 < sign * model.strengths[-1] < 0.02
    assert refused(model) == []


def test_when_friction_turns_is_known_no_better_than_position_tells(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # All of an effort comes late by four samples, and friction seems to by one.
    def hidden(instant: Instant) -> np.ndarray:
        return late(instant.friction, instant, 0.0012) + late(instant.rigid, instant, 0.004)

    log, robot = write_case(tmp_path, Machine(noise=0.02, hidden={SHOULDER: hidden}), 1, seconds=30.0, rate=1000.0)
    gap = measure_gap(read_log(log), read_robot(robot), highest=30.0)
    delay = Chosen(JointDelay(), Site(SHOULDER))
    model = build_model(gap, make_nuisance(gap), (delay,))
    assert model.strengths[-1] == pytest.approx(0.004, rel=0.1)
    assert refused(model) == []
    monkeypatch.setattr(refusal, "BLURRED", 0.0)
    assert [choice.key for choice in refused(model)] == [delay.key]


@pytest.mark.parametrize("part", ["all", "friction"])
def test_so_is_a_delay_of_the_whole_arm(part: str, tmp_path: Path) -> None:
    def hidden(instant: Instant) -> np.ndarray:
        return late(instant.friction + (instant.rigid if part == "all" else 0.0), instant, 0.03)

    gap = gap_of_machine(tmp_path, Machine(hidden=dict.fromkeys(range(6), hidden)))
    delay = Chosen(LogDelay(), Site(SHOULDER, around=0.025))
    model = build_model(gap, make_nuisance(gap), (delay,))
    assert [choice.key for choice in refused(model)] == ([] if part == "all" else [delay.key])


@pytest.mark.parametrize(("damping", "refusals"), [(0.0, 0), (-6.0, 1)])
def test_a_step_that_lowers_friction_when_fast_and_raises_it_when_slow_is_refused(
    damping: float, refusals: int, tmp_path: Path
) -> None:
    def stepped(instant: Instant) -> np.ndarray:
        return (2.5 * np.sign(instant.v) + damping * instant.v) * (instant.time > 15.0)

    gap = gap_of_machine(tmp_path, Machine(hidden={ELBOW: stepped}))
    model = build_model(gap, make_nuisance(gap), (Chosen(Step(), Site(ELBOW, shape=(15.0,))),))
    assert len(refused(model)) == refusals


@pytest.mark.parametrize(("joints", "refusals"), [((1, 2), 0), ((1, 2, 3), 3)])
def test_accelerations_that_joints_all_over_the_arm_feel_are_no_couplings(
    joints: tuple[int, ...], refusals: int, tmp_path: Path
) -> None:
    def felt(instant: Instant) -> np.ndarray:
        return 0.6 * np.gradient(instant.velocities[:, 0], instant.time)

    gap = gap_of_machine(tmp_path, Machine(hidden=dict.fromkeys(joints, felt)))
    couplings = tuple(Chosen(SharedMotion(), Site(joint, other=0)) for joint in joints)
    assert len(refused(build_model(gap, make_nuisance(gap), couplings))) == refusals


@pytest.mark.parametrize("bent", [True, False])
def test_a_reading_that_bends_as_it_grows_is_no_friction_under_load(*, bent: bool, tmp_path: Path) -> None:
    def effect(at: Instant) -> np.ndarray:
        whole = at.rigid + at.friction
        return 2e-3 * whole * np.abs(whole) if bent else 0.15 * np.abs(at.rigid) * np.sign(at.v)

    gap = gap_of_machine(tmp_path, Machine(noise=0.05, hidden={PAN: effect}))
    model = build_model(gap, make_nuisance(gap), (Chosen(Load(), Site(PAN)),))
    # Where nothing pulls at the joint, both raise the effort where it is large.
    (load,) = model.chosen
    trial = try_out(model.without(load), load)
    assert trial is not None
    assert trial.gain > 0.0
    assert (load in refused(model)) is bent


def test_a_level_that_fades_while_the_joint_moves_is_proved_by_rows_in_some_doubt(tmp_path: Path) -> None:
    def fading(instant: Instant) -> np.ndarray:
        return 2.5 * np.sign(instant.v) * np.exp(-np.square(instant.v / 0.03))

    gap = gap_of_machine(tmp_path, Machine(hidden={ELBOW: fading}))
    curve = Chosen(Stribeck(), Site(ELBOW, shape=(0.03, 2.0)))
    assert refused(build_model(gap, make_nuisance(gap), (curve,))) == []
    # Where nothing fades the same curve is refused.
    plain = gap_of_machine(tmp_path, Machine())
    assert [one.key for one in refused(build_model(plain, make_nuisance(plain), (curve,)))] == [curve.key]


def test_what_shows_only_beside_another_cause_is_asked_again_once_that_is_found(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fading(instant: Instant) -> np.ndarray:
        return 4.0 * np.sign(instant.v) * np.exp(-np.square(instant.v / 0.15))

    def loaded(instant: Instant) -> np.ndarray:
        return 0.03 * np.abs(instant.rigid) * np.sign(instant.v)

    gap = gap_of_machine(tmp_path, Machine(hidden={ELBOW: fading, SHOULDER: loaded}))
    field, asked = make_field(gap, (Load(), Stribeck())), []
    known = with_unevenness(gap, make_nuisance(gap))
    larger, lesser = ("friction.stribeck", ELBOW), ("friction.load", SHOULDER)

    def found(is_proved: Callable[[set[tuple[str, int]], str], bool]) -> list[tuple[str, int]]:
        def judged(model: Model, choice: Chosen) -> bool:
            asked.append(choice.key[:2])
            return is_proved({other.key[:2] for other in model.chosen}, choice.cause.name)

        asked.clear()
        monkeypatch.setattr(compete, "proved", judged)
        bare, chances = build_model(gap, known, ()), chances_in(field)
        grown, _ = compete._forward(bare, field, chances, silently, compete.never)
        return [one.key[:2] for one in grown.chosen]

    assert found(lambda chosen, name: True)[:2] == [larger, lesser]
    assert found(lambda chosen, name: name != larger[0] or lesser in chosen)[:2] == [lesser, larger]
    assert asked.count(larger) == 2
    assert larger not in found(lambda chosen, name: name != larger[0])
    assert asked.count(larger) == 2


def test_friction_that_builds_up_does_so_on_the_way_and_not_at_rest_alone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    gap = gap_of_machine(tmp_path, Machine(pauses=True))
    bristle = Chosen(Presliding(), Site(ELBOW, shape=(0.01,)))
    built_up = cause_block(gap, bristle)[0][ELBOW] @ [0.5 * UR5_COULOMB[ELBOW]]
    moving = np.abs(gap.at_rows("velocity")[:, ELBOW]) > gap.doubt_speed[ELBOW]

    def found(surer_at_rest: float) -> tuple[Model, Chosen]:
        residual, doubt = gap.residual.copy(), gap.doubt.copy()
        residual[:, ELBOW] += built_up
        doubt[~moving, ELBOW] /= surer_at_rest
        model = build_model(replace(gap, residual=residual, doubt=doubt), make_nuisance(gap), (bristle,))
        return model, bristle

    assert refusal.proved(*found(1.0))
    held = found(1e3)
    assert not refusal.proved(*held)
    monkeypatch.setattr(refusal, "ON_THE_WAY", -np.inf)
    assert refusal.proved(*held)


def test_what_the_filter_of_any_drive_takes_is_no_delay(tmp_path: Path) -> None:
    def noteworthy(seconds: float) -> list[str]:
        def hidden(instant: Instant, joint: int) -> np.ndarray:
            return late(instant.rigid + instant.friction, instant, seconds)

        machine = Machine(noise=0.02, hidden={joint: partial(hidden, joint=joint) for joint in range(6)})
        log, robot = write_case(tmp_path / f"{seconds}", machine, 1, seconds=20.0, rate=1000.0)
        gap = measure_gap(read_log(log), read_robot(robot))
        model = build_model(gap, make_nuisance(gap), (Chosen(LogDelay(), Site(SHOULDER)),))
        assert model.strengths[-1] == pytest.approx(seconds, rel=0.2)
        return [choice.cause.name for choice in model.noteworthy]

    assert noteworthy(0.002) == []
    assert noteworthy(0.005) == ["sensor.delay"]
