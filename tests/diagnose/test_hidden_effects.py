"""An effect is hidden in a machine of other code; the diagnosis must name it, at its joint, within its interval."""

from __future__ import annotations

import functools
import tempfile
from collections.abc import Callable, Mapping, Set
from dataclasses import dataclass, field, replace
from pathlib import Path

import mujoco
import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

import mjfriction.diagnose.diagnosis as module
from mjfriction.diagnose.causes import links
from mjfriction.diagnose.diagnosis import diagnose_log
from mjfriction.diagnose.fit import nuisance, refitted, trial
from mjfriction.diagnose.fit.model import Chosen, Model, build_model
from mjfriction.diagnose.settle import stated
from mjfriction.diagnose.tell import link_finding, untold
from mjfriction.diagnose.tell.outcome import Diagnosis, Verdict
from mjfriction.record.readers import read_log
from mjfriction.record.readers.table import log_from_table
from mjfriction.robot.files import read_robot
from mjfriction.robot.predict import predict_log
from tests.deep import deep
from tests.hidden.closed_loop import record_closed_loop
from tests.hidden.machine import UR5_COULOMB, UR5_JOINTS, UR5_VISCOUS, Instant, Machine, bristle, record, write_case


@dataclass(frozen=True)
class Case:
    cause: str
    joint: int
    effect: Callable[[Instant], np.ndarray]
    parameters: dict[str, float]
    in_sensor: bool = False  # whether the effect is in what the position sensor reads, not in the torque
    ambient: Mapping[str, Callable[[np.ndarray], np.ndarray]] = field(default_factory=dict)

    @property
    def machine(self) -> Machine:
        own = {self.joint: self.effect}
        return (
            Machine(sensed=own, ambient=self.ambient) if self.in_sensor else Machine(hidden=own, ambient=self.ambient)
        )


def warmth(time: np.ndarray) -> np.ndarray:
    return 28.0 + 14.0 * (1.0 - np.exp(-time / 25.0))


def pressures(slow: float) -> Callable[[np.ndarray], np.ndarray]:
    return lambda time: 4e6 + 1.5e6 * np.sin(slow * time) + 1e6 * np.cos(1.7 * slow * time)


CASES = [
    Case(
        "friction.stribeck",
        2,
        lambda i: 3.0 * np.sign(i.v) * np.exp(-((i.v / 0.15) ** 2)),
        {"stribeck_excess": 3.0, "stribeck_velocity": 0.15, "stribeck_exponent": 2.0},
    ),
    Case("friction.viscous_nonlinear", 3, lambda i: -0.6 * i.v * np.abs(i.v), {"quadratic": -0.6}),
    Case("friction.asymmetry", 1, lambda i: 4.0 * np.abs(i.v), {"viscous_asymmetry": 4.0}),
    Case("drive.offset", 4, lambda i: np.full(i.v.shape, -0.5), {"offset": -0.5}),
    Case("drive.rotor_inertia", 5, lambda i: 0.3 * i.a, {"rotor_inertia": 0.3}),
    Case("drive.torque_constant", 1, lambda i: 0.12 * (i.rigid + i.friction), {"factor": 1.12}),
    Case("friction.load", 1, lambda i: 0.06 * np.abs(i.rigid) * np.sign(i.v), {"load": 0.06}),
    Case("body.spring", 1, lambda i: 8.0 * (i.q + 0.5), {"stiffness": 8.0, "preload": 4.0}),
    Case(
        "drive.cogging",
        0,
        lambda i: 2.0 * np.cos(14.0 * i.q + 0.5),
        {"wavenumber": 14.0, "cosine": 2.0 * np.cos(0.5), "sine": -2.0 * np.sin(0.5)},
    ),
    Case(
        "friction.position",
        3,
        lambda i: 0.7 * np.sin(8.0 * i.q) * np.sign(i.v),
        {"wavenumber": 8.0, "cosine": 0.0, "sine": 0.7},
    ),
    Case(
        "friction.coulomb_viscous",
        0,
        lambda i: 2.5 * np.sign(i.v) - 2.0 * i.v,
        {"coulomb": 11.5, "viscous": 9.0},
    ),
]
CASES += [
    Case(
        "friction.presliding",
        0,
        lambda i: 8.0 * (bristle(i.q, 0.02) - np.sign(i.v)),
        {"presliding_level": 8.0, "presliding_travel": 0.02},
    ),
    Case(
        "friction.temperature",
        1,
        lambda i: (warmth(i.time) - 25.0) * (-0.25 * np.sign(i.v) - 0.3 * i.v),
        {"coulomb_per_kelvin": -0.25, "viscous_per_kelvin": -0.3},
        ambient={f"temperature.{UR5_JOINTS[1]}": warmth},
    ),
    Case(
        "event.change",
        3,
        lambda i: (i.time > 23.7) * (0.8 * np.sign(i.v) + 0.6 * i.v),
        {"time": 23.7, "coulomb": 0.8, "viscous": 0.6},
    ),
    Case(
        "hydraulic.pressure",
        2,
        lambda i: (8e-7 * pressures(0.5)(i.time) + 3e-7 * pressures(0.9)(i.time)) * np.sign(i.v),
        {"head": 8e-7, "rod": 3e-7},
        ambient={
            f"pressure_head.{UR5_JOINTS[2]}": pressures(0.5),
            f"pressure_rod.{UR5_JOINTS[2]}": pressures(0.9),
        },
    ),
    Case(
        "drive.coupling",
        5,
        lambda i: 0.5 * np.sign(i.velocities[:, 4]) + 0.4 * i.velocities[:, 4],
        {"coulomb": 0.5, "viscous": 0.4},
    ),
    Case("sensor.encoder_offset", 2, lambda i: np.full(i.q.shape, 0.08), {"offset": 0.08}, in_sensor=True),
    Case("drive.elasticity", 1, lambda i: 1.5e-3 * i.rigid, {"compliance": 1.5e-3}, in_sensor=True),
]
ELSEWHERE = {
    "body.spring",
    "drive.cogging",
    "drive.offset",
    "drive.torque_constant",
    "event.change",
    "friction.asymmetry",
    "friction.coulomb_viscous",
    "friction.load",
    "friction.position",
    "friction.presliding",
    "friction.stribeck",
    "friction.temperature",
    "friction.viscous_nonlinear",
    "hydraulic.pressure",
}
"""Causes that tests of their own, or other tests here, find among those that ``make test`` runs."""


def cases(deep: Set[str]) -> pytest.MarkDecorator:
    marked = [pytest.param(case, id=case.cause, marks=[pytest.mark.deep] * (case.cause in deep)) for case in CASES]
    return pytest.mark.parametrize("case", marked)


def run(folder: Path, machine: Machine, seed: int, *, off: float = 0.0, seconds: float = 40.0) -> Diagnosis:
    log, robot = write_case(folder, machine, seed, off=off, seconds=seconds)
    return diagnose_log(read_log(log), read_robot(robot))


@functools.cache
def diagnosed(cause: str) -> Diagnosis:
    """Diagnose a case once for all the tests that ask for it."""
    case = next(case for case in CASES if case.cause == cause)
    with tempfile.TemporaryDirectory() as folder:
        return run(Path(folder), case.machine, seed=21)


def names(diagnosis: Diagnosis) -> list[tuple[str, str | None]]:
    return [(finding.cause, finding.joint) for finding in diagnosis.findings]


@cases(deep=ELSEWHERE)
def test_the_cause_is_named_with_its_size(case: Case) -> None:
    diagnosis = diagnosed(case.cause)
    assert names(diagnosis) == [(case.cause, UR5_JOINTS[case.joint])]
    (finding,) = diagnosis.findings
    assert finding.confidence > 0.85
    assert finding.alternatives == ()
    assert diagnosis.verdict is Verdict.EXPLAINED
    for fitted in finding.parameters:
        if fitted.name == "damping_ratio":  # of a spring that is not damped, along motion that hardly shakes it
            assert fitted.value <= 0.1
            continue
        true = case.parameters[fitted.name]
        # Twice the interval: a dozen cases at 95 % would miss one in two runs for no fault.
        assert abs(fitted.value - true) < 2.0 * (fitted.high - fitted.value), fitted
        assert fitted.value == pytest.approx(true, rel=0.25, abs=0.05), fitted
    assert finding.gain.low > 0.05


ALIKE = {
    "friction.coulomb_viscous",
    "friction.load",
    "drive.torque_constant",
    "drive.offset",
    "body.spring",
    "sensor.encoder_offset",
}
"""Levels are refitted with every candidate, a scaled effort is nearly scaled links and levels, a constant may be a
spring, and a spring is nearly a zero that is off with links a little heavier, and the other way round; friction under
a load that the pose changes is nearly one that changes along the stroke by half a wave: what can be fitted without
those names does not show in the error.
"""
SLOW = {
    "drive.cogging",
    "drive.elasticity",
    "drive.rotor_inertia",
    "event.change",
    "friction.asymmetry",
    "friction.presliding",
    "friction.stribeck",
    "friction.temperature",
}


@cases(deep=ALIKE | SLOW | ELSEWHERE)
def test_without_the_cause_among_the_candidates_it_is_not_found(
    case: Case, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    machine = case.machine
    with_it = diagnosed(case.cause)
    kept = tuple(cause for cause in module.STRUCTURAL if cause.name != case.cause)
    monkeypatch.setattr(module, "STRUCTURAL", kept)
    monkeypatch.setattr("mjfriction.diagnose.settle.stated.LEAST_CHANGE", np.inf)
    without_it = run(tmp_path, machine, seed=21)
    assert (case.cause, UR5_JOINTS[case.joint]) not in names(without_it)
    if case.cause not in ALIKE:
        left = [d.joints[case.joint].rms_heldout_after for d in (with_it, without_it)]
        assert left[1] > 1.05 * left[0]


@cases(deep=ELSEWHERE)
def test_the_extended_robot_predicts_motion_it_was_not_fitted_to(case: Case, tmp_path: Path) -> None:
    machine = case.machine
    diagnosis = diagnosed(case.cause)
    other_log, robot_path = write_case(tmp_path / "other", machine, seed=22)
    exact = record(replace(machine, noise=0.0), seed=22)[f"effort.{UR5_JOINTS[case.joint]}"]
    log = read_log(other_log)
    name = f"effort.{UR5_JOINTS[case.joint]}"
    speed = np.abs(np.gradient(log.columns[name.replace("effort", "position")], 1.0 / 250.0))
    moving = speed > 0.08
    errors = [
        float(np.sqrt(np.mean((predict_log(log, robot)[name] - exact)[moving] ** 2)))
        for robot in (read_robot(robot_path), diagnosis.robot)
    ]
    # What moves the sensor acts most where the load turns over, and there the position's filter blurs it.
    assert errors[1] < (0.9 if case.in_sensor else 0.5) * errors[0]


def test_two_effects_are_both_found_when_stated_friction_is_a_few_percent_off(tmp_path: Path) -> None:
    hidden = {2: CASES[0].effect, 1: CASES[2].effect}
    diagnosis = run(tmp_path, Machine(hidden=hidden), seed=33, off=0.03)
    assert set(names(diagnosis)) == {
        ("friction.stribeck", "elbow_joint"),
        ("friction.asymmetry", "shoulder_lift_joint"),
    }


@pytest.mark.deep
def test_damping_that_levels_off_is_one_bend_and_nothing_else(tmp_path: Path) -> None:
    diagnosis = run(tmp_path, Machine(hidden={3: lambda i: 3.0 * i.v / (1.0 + np.abs(i.v) / 0.5)}), seed=21)
    assert names(diagnosis) == [("friction.viscous_nonlinear", "wrist_1_joint")]
    fitted = {parameter.name: parameter for parameter in diagnosis.findings[0].parameters}
    assert fitted["viscous"].value == pytest.approx(3.0, rel=0.25)
    assert fitted["half_velocity"].value == pytest.approx(0.5, rel=0.25)
    assert fitted["half_velocity"].low < 0.5 < fitted["half_velocity"].high


def test_what_no_cause_fits_is_unexplained_and_placed(tmp_path: Path) -> None:
    # A torque that wanders with time, as no cause known here does.
    diagnosis = run(tmp_path, Machine(hidden={2: lambda i: 3.0 * np.sin(2.0 * np.pi * i.time / 25.0)}), seed=8)
    assert diagnosis.verdict is Verdict.UNEXPLAINED
    assert ("elbow_joint", "time") in {(entry.joint, entry.covariate) for entry in diagnosis.remaining}
    assert "elbow_joint" in diagnosis.summary


@pytest.mark.deep
def test_care_for_reversals_is_what_finds_a_curve_near_rest(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # A simulated arm whose elbow sticks and breaks loose; rows near that, believed like all others, are in bursts.
    log = tmp_path / "log.parquet"
    pq.write_table(record_closed_loop(7, fading=2, excess=3.5, over=0.12), log)

    def found() -> Diagnosis:
        return diagnose_log(read_log(log), read_robot("ur5"))

    careful = found()
    assert names(careful) == [("friction.stribeck", "elbow_joint")]
    assert careful.findings[0].parameters[0].value == pytest.approx(3.5, rel=0.1)
    monkeypatch.setattr(
        "mjfriction.identify.measure.share_in_doubt",
        lambda _, motion, chain, *rest: chain.rows(0.0 * motion.position),
    )
    careless = found()
    assert careless.verdict is Verdict.UNEXPLAINED
    assert not names(careless)


def heavier(model: mujoco.MjModel) -> None:
    body = model.body("wrist_3_link").id
    mass, centre, held = model.body_mass[body], model.body_ipos[body].copy(), np.array([0.0, 0.05, 0.03])
    model.body_ipos[body] = (mass * centre + 0.6 * held) / (mass + 0.6)
    model.body_mass[body] = mass + 0.6


def tilted(model: mujoco.MjModel) -> None:
    angle = np.radians(3.0)
    model.opt.gravity[:] = 9.81 * np.array([0.6 * np.sin(angle), 0.8 * np.sin(angle), -np.cos(angle)])


@pytest.mark.parametrize("off", [deep(0.0), 0.03])
def test_a_payload_is_weighed_and_placed(off: float, tmp_path: Path) -> None:
    diagnosis = run(tmp_path, Machine(change=heavier), seed=5, off=off)
    (finding,) = diagnosis.findings
    assert (finding.cause, finding.joint) == ("body.payload", None)
    payload = diagnosis.robot.table.payload
    assert payload is not None
    assert payload.parent == "wrist_3_link"
    assert payload.mass == pytest.approx(0.6, rel=0.03)
    assert payload.com == pytest.approx((0.0, 0.05, 0.03), abs=0.003)


@pytest.mark.deep
@pytest.mark.parametrize("by_temperature", [False, True])
def test_stated_levels_may_be_those_of_a_warm_joint(by_temperature: bool, tmp_path: Path) -> None:
    def cold(i: Instant) -> np.ndarray:
        return 0.4 * np.exp(-i.time / 25.0) * (UR5_COULOMB[2] * np.sign(i.v) + UR5_VISCOUS[2] * i.v)

    def cold_and_rough(i: Instant) -> np.ndarray:
        return cold(i) + 0.5 * UR5_COULOMB[2] * np.sign(i.v)

    ambient = {"temperature.elbow_joint": warmth} if by_temperature else {}
    warm, rough = (
        run(tmp_path / effect.__name__, Machine(hidden={2: effect}, ambient=ambient), seed=21)
        for effect in (cold, cold_and_rough)
    )
    assert names(warm) == [("friction.temperature", "elbow_joint")]
    # No moment of the warm-up has half of the level more and the damping as stated.
    assert set(names(rough)) == {("friction.temperature", "elbow_joint"), ("friction.coulomb_viscous", "elbow_joint")}


@pytest.mark.parametrize(
    ("parent", "com"),
    [
        deep("wrist_3_joint", "[0.0, 0.05, 0.03]"),
        deep("tool0", "[0.0, -0.03, -0.0323]"),
    ],
)
def test_a_payload_heavier_than_the_one_stated_is_found_wherever_it_is_stated(
    parent: str, com: str, tmp_path: Path
) -> None:
    log, robot = write_case(tmp_path, Machine(change=heavier), seed=5)
    text = robot.read_text(encoding="utf-8")
    stated = f'payload = {{ mass = 0.25, com = {com}, parent = "{parent}" }}'
    robot.write_text(text.replace("[[joint]]", f"{stated}\n[[joint]]", 1), encoding="utf-8")
    diagnosis = diagnose_log(read_log(log), read_robot(robot))
    assert names(diagnosis) == [("body.payload", None)]
    payload = diagnosis.robot.table.payload
    assert payload is not None
    assert payload.parent == "wrist_3_link"
    assert payload.mass == pytest.approx(0.6, rel=0.03)
    assert payload.com == pytest.approx((0.0, 0.05, 0.03), abs=0.003)


def a_few_percent_off(model: mujoco.MjModel) -> None:
    rng = np.random.default_rng(2)
    for body in range(1, model.nbody):
        if model.body_mass[body] > 0.1:
            model.body_mass[body] *= 1.0 + 0.03 * rng.normal()
            model.body_ipos[body] += 0.002 * rng.normal(size=3)
            model.body_inertia[body] *= 1.0 + 0.05 * rng.normal(size=3)


@pytest.mark.deep
def test_links_a_few_percent_off_in_all_they_have_are_no_finding(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def found(name: str) -> Diagnosis:
        machine = Machine(change=a_few_percent_off, noise=0.05)
        return run(tmp_path / name, machine, seed=2, off=0.03, seconds=60.0)

    assert found("as it is").findings == ()
    # A scale and a centre for each are not enough to say so: one link would be told to be 9 % off.
    for place in (untold, link_finding):
        monkeypatch.setattr(place, "links_far_off", lambda _: True)
    assert names(found("of scales and centres")) == [("body.link_inertia", None)]


def on_the_axis(model: mujoco.MjModel) -> None:
    body = model.body("wrist_3_link").id
    mass, centre, held = model.body_mass[body], model.body_ipos[body].copy(), np.array([0.0, 0.06, 0.0])
    model.body_ipos[body] = (mass * centre + 1.5 * held) / (mass + 1.5)
    model.body_mass[body] = mass + 1.5


@pytest.mark.deep
def test_a_payload_that_the_last_joint_does_not_feel_is_no_link(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def found(name: str) -> Diagnosis:
        return run(tmp_path / name, Machine(change=on_the_axis, noise=0.1), seed=5)

    diagnosis = found("as it is")
    assert names(diagnosis) == [("body.payload", None)]
    payload = diagnosis.robot.table.payload
    assert payload is not None
    assert payload.mass == pytest.approx(1.5, rel=0.01)
    assert payload.com == pytest.approx((0.0, 0.06, 0.0), abs=0.001)

    where_it_is_most = trial.effects

    def at_its_own_joint(model: Model, choice: Chosen, strengths: np.ndarray, joint: int) -> tuple[float, float]:
        return where_it_is_most(model, choice, strengths, choice.site.joint)

    monkeypatch.setattr(trial, "effects", at_its_own_joint)
    assert ("body.payload", None) not in names(found("measured at the last joint"))


@pytest.mark.deep
def test_links_that_lie_millimetres_off_are_no_finding(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def loose(model: mujoco.MjModel) -> None:
        rng = np.random.default_rng(4)
        model.body_ipos[1:] += 0.003 * rng.normal(size=(model.nbody - 1, 3))
        scale = 1.0 + 0.02 * rng.normal(size=model.nbody - 1)
        model.body_mass[1:] *= scale
        model.body_inertia[1:] *= scale[:, None]

    def found(name: str) -> Diagnosis:
        return run(tmp_path / name, Machine(change=loose, noise=0.1), seed=5)

    assert found("as it is").findings == ()
    monkeypatch.setattr(refitted, "LINK_SHIFT", 1e-6)
    monkeypatch.setattr(links.LinkCentre, "least_moved", 0.0)
    assert {"body.link_inertia"} == {name for name, _ in names(found("with centres held"))}


@pytest.mark.parametrize("off", [deep(0.0), 0.03])
def test_a_tilted_base_is_levelled(off: float, tmp_path: Path) -> None:
    diagnosis = run(tmp_path, Machine(change=tilted), seed=5, off=off)
    (finding,) = diagnosis.findings
    assert (finding.cause, finding.joint) == ("body.gravity_direction", None)
    gravity = diagnosis.robot.table.gravity
    assert gravity is not None
    sine = np.sin(np.radians(3.0))
    assert gravity == pytest.approx((9.81 * 0.6 * sine, 9.81 * 0.8 * sine, -9.81 * np.cos(np.radians(3.0))), abs=0.03)


def test_play_is_named_where_the_load_crosses_it(tmp_path: Path) -> None:
    machine = Machine(sensed={2: lambda i: 0.005 * np.sign(i.rigid)})
    log, robot = write_case(tmp_path, machine, 1, seconds=60.0)
    (finding,) = diagnose_log(read_log(log), read_robot(robot)).findings
    assert (finding.cause, finding.joint) == ("drive.backlash", "elbow_joint")
    assert finding.parameters[0].value == pytest.approx(0.01, rel=0.01)


def late(seconds: float) -> Callable[[Instant], np.ndarray]:
    return lambda i: np.interp(i.time - seconds, i.time, i.rigid + i.friction) - (i.rigid + i.friction)


def early(rigid: float, friction: float) -> Callable[[Instant], np.ndarray]:
    def effect(i: Instant) -> np.ndarray:
        parts = ((i.rigid, rigid), (i.friction, friction))
        return np.sum([np.interp(i.time + seconds, i.time, part) - part for part, seconds in parts], axis=0)

    return effect


@pytest.mark.deep
@pytest.mark.parametrize(
    ("hidden", "told"),
    [(early(0.02, 0.02), True), (early(0.06, 0.06), True), (early(0.06, 0.0), False), (early(0.05, 0.12), False)],
)
def test_an_effort_that_comes_early_does_so_with_its_friction(
    hidden: Callable[[Instant], np.ndarray], told: bool, tmp_path: Path
) -> None:
    log, robot = write_case(tmp_path, Machine(hidden={2: hidden}), 5, seconds=40.0)
    found = {(one.cause, one.joint) for one in diagnose_log(read_log(log), read_robot(robot)).findings}
    assert (("sensor.delay", "elbow_joint") in found) is told


@pytest.mark.deep
def test_a_late_effort_is_timed(tmp_path: Path) -> None:
    one = run(tmp_path / "one", Machine(hidden={1: late(0.02)}), seed=5)
    assert names(one) == [("sensor.delay", "shoulder_lift_joint")]
    (delay,) = one.findings[0].parameters
    assert abs(delay.value - 0.02) < 2.0 * (delay.high - delay.value)
    assert delay.value == pytest.approx(0.02, rel=0.1)
    every = run(tmp_path / "all", Machine(hidden={j: late(0.02) for j in range(6)}), seed=5)
    assert names(every) == [("sensor.delay", None)]
    delays = {joint.effort_sensor.delay for joint in every.robot.table.joint}
    assert len(delays) == 1
    assert delays.pop() == pytest.approx(0.02, rel=0.1)


@pytest.mark.deep
def test_a_torque_constant_a_few_percent_off_is_a_finding_on_an_exact_robot_only(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    machine = Machine(noise=0.1, hidden={1: lambda i: 0.05 * (i.rigid + i.friction)})
    finding = ("drive.torque_constant", "shoulder_lift_joint")
    assert names(run(tmp_path / "exact", machine, seed=21)) == [finding]
    rough = run(tmp_path / "rough", machine, seed=21, off=0.05)
    assert names(rough) == []
    factors = {entry.joint: entry.fitted for entry in rough.adjustments if entry.what == "factor"}
    assert factors.pop("shoulder_lift_joint") == pytest.approx(1.05, abs=0.01)
    assert all(factor == pytest.approx(1.0, abs=0.01) for factor in factors.values())
    # Refitted always, it is no finding; nor is it one where it is not.
    monkeypatch.setattr(module, "usual_nuisance", nuisance.make_nuisance)
    assert names(run(tmp_path / "not refitted", machine, seed=21, off=0.05)) == []
    monkeypatch.setattr("mjfriction.diagnose.causes.torque_constant.USUALLY_OFF", 0.0)
    assert finding in names(run(tmp_path / "told", machine, seed=21, off=0.05))


@pytest.mark.deep
def test_a_rotor_a_few_percent_off_is_a_finding_on_an_exact_robot_only(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    rotor, more, elbow = 3.0, 0.06, "elbow_joint"
    machine = Machine(noise=0.1, hidden={2: lambda i: (1.0 + more) * rotor * i.a})

    def found(off: float) -> Diagnosis:
        log, path = write_case(tmp_path / str(off), machine, seed=21, off=off)
        robot = read_robot(path)
        table = robot.joint(elbow)
        actuator = table.actuator.model_copy(update={"rotor_inertia": rotor / table.actuator.gear_ratio**2})
        return diagnose_log(read_log(log), robot.with_joint(table.model_copy(update={"actuator": actuator})))

    finding = ("drive.rotor_inertia", elbow)
    assert names(found(0.0)) == [finding]
    rough = found(0.05)
    assert names(rough) == []
    (inertia,) = [entry for entry in rough.adjustments if entry.what == "rotor_inertia"]
    assert inertia.fitted == pytest.approx((1.0 + more) * inertia.stated, rel=0.02)
    monkeypatch.setattr(module, "usual_nuisance", nuisance.make_nuisance)
    assert names(found(0.05)) == []
    monkeypatch.setattr("mjfriction.diagnose.causes.rotor_inertia.USUALLY_OFF", 0.0)
    assert finding in names(found(0.05))


@pytest.mark.parametrize("begin", [deep(-5.0), 1.7e9])
def test_courses_of_time_are_found_on_any_clock(begin: float, tmp_path: Path) -> None:
    def steps(i: Instant) -> np.ndarray:
        return 2.0 * np.sign(i.v) * (i.time > 24.0)

    def warms(i: Instant) -> np.ndarray:
        return -3.0 * np.sign(i.v) * (1.0 - np.exp(-i.time / 15.0))

    log, robot = write_case(tmp_path, Machine(noise=0.1, hidden={1: warms, 2: steps}), seed=21)
    columns = pq.read_table(log)
    moved = columns.set_column(0, "time", pa.array(columns["time"].to_numpy() + begin))
    assert columns.column_names[0] == "time"
    diagnosis = diagnose_log(log_from_table(moved, "log"), read_robot(robot))
    found = {finding.cause: finding for finding in diagnosis.findings}
    assert {(f.cause, f.joint) for f in diagnosis.findings} == {
        ("event.change", "elbow_joint"),
        ("friction.temperature", "shoulder_lift_joint"),
    }
    moment = next(own for own in found["event.change"].parameters if own.name == "time")
    assert moment.value - begin == pytest.approx(24.0, abs=0.3)
    assert moment.low <= begin + 24.0 <= moment.high
    constant = next(own for own in found["friction.temperature"].parameters if own.name == "time_constant")
    assert constant.value == pytest.approx(15.0, rel=0.2)
    # The extended robot says so on the log's own clock.
    predicted = predict_log(log_from_table(moved, "log"), diagnosis.robot)
    missed = columns["effort.elbow_joint"].to_numpy() - predicted["effort.elbow_joint"]
    assert np.sqrt(np.mean(np.square(missed))) < 1.3 * 0.1 * UR5_COULOMB[2]


@pytest.mark.deep
def test_the_stated_level_may_be_that_of_after_a_step(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    machine = Machine(noise=0.1, hidden={2: lambda i: 3.0 * np.sign(i.v) * (i.time < 24.0)})
    step, level = ("event.change", "elbow_joint"), ("friction.coulomb_viscous", "elbow_joint")
    asked = []
    monkeypatch.setattr(stated, "scaled_levels", lambda _, __, own, ___: asked.append(own.chosen.site.joint))
    assert names(run(tmp_path / "as it is", machine, seed=21)) == [step]
    assert asked == []  # whether one factor explains it
    monkeypatch.setattr(stated, "_of_another_moment", lambda *_: False)
    assert set(names(run(tmp_path / "told", machine, seed=21))) == {step, level}
    assert asked == [2]


@pytest.mark.deep
def test_friction_that_is_a_little_uneven_everywhere_is_no_finding(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def uneven(joint: int) -> Callable[[Instant], np.ndarray]:
        level = 0.03 * UR5_COULOMB[joint]
        return lambda i: level * np.cos((5.0 + joint) * i.q + joint) * np.sign(i.v)

    machine = Machine(noise=0.03, hidden={joint: uneven(joint) for joint in range(6)})
    plain = run(tmp_path / "as it is", machine, seed=21)
    assert names(plain) == []
    assert plain.verdict is Verdict.CONSISTENT
    # A single wave as small on a machine that is even is one.
    one = Machine(noise=0.03, hidden={2: uneven(2)})
    assert names(run(tmp_path / "one", one, seed=21)) == [("friction.position", "elbow_joint")]
    monkeypatch.setattr("mjfriction.diagnose.search.unevenness.UNEVEN", np.inf)
    monkeypatch.setattr("mjfriction.diagnose.fit.trial.STANDS_OUT", 0.0)
    told = [cause for cause, _ in names(run(tmp_path / "told", machine, seed=21))]
    assert set(told) == {"friction.position"}
    assert len(told) >= 5


@pytest.mark.deep
def test_the_ripple_of_gears_is_told_where_it_stands_out(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def cogs(joint: int, share: float) -> Callable[[Instant], np.ndarray]:
        return lambda i: share * UR5_COULOMB[joint] * np.cos(50.0 * i.q + joint)

    alike = Machine(noise=0.03, hidden={1: cogs(1, 0.09), 2: cogs(2, 0.08), 4: cogs(4, 0.09)})
    assert names(run(tmp_path / "alike", alike, seed=21)) == []
    larger = Machine(noise=0.03, hidden={1: cogs(1, 0.09), 2: cogs(2, 0.25), 4: cogs(4, 0.09)})
    assert names(run(tmp_path / "larger", larger, seed=21)) == [("drive.cogging", "elbow_joint")]
    large = Machine(noise=0.03, hidden={1: cogs(1, 0.25), 2: cogs(2, 0.25)})
    both = {("drive.cogging", "shoulder_lift_joint"), ("drive.cogging", "elbow_joint")}
    assert set(names(run(tmp_path / "large", large, seed=21))) == both
    monkeypatch.setattr("mjfriction.diagnose.fit.trial.STANDS_OUT", 0.0)
    told = names(run(tmp_path / "told", alike, seed=21))
    assert len(told) >= 2
    assert {cause for cause, _ in told} == {"drive.cogging"}


@pytest.mark.deep
def test_a_warm_up_of_two_time_constants_is_one_warm_up(tmp_path: Path) -> None:
    def warms(i: Instant) -> np.ndarray:
        share = 0.7 * (1.0 - np.exp(-i.time / 2.0)) + 0.3 * (1.0 - np.exp(-i.time / 25.0))
        return -5.5 * share * np.sign(i.v)

    machine = Machine(noise=0.1, hidden={2: warms})
    assert names(run(tmp_path, machine, seed=21)) == [("friction.temperature", "elbow_joint")]


@pytest.mark.deep
def test_what_a_late_drive_reports_of_another_cause_is_late_too(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def uneven(i: Instant) -> np.ndarray:
        return 3.0 * np.cos(12.0 * i.q) * np.sign(i.v)

    def uneven_and_late(i: Instant) -> np.ndarray:
        whole = i.rigid + i.friction + uneven(i)
        return np.interp(i.time - 0.05, i.time, whole) - i.rigid - i.friction

    machine = Machine(hidden={2: uneven_and_late})
    both = {("friction.position", "elbow_joint"), ("sensor.delay", "elbow_joint")}
    diagnosis = run(tmp_path / "late", machine, seed=5)
    assert set(names(diagnosis)) == both
    fitted = {parameter.name: parameter.value for finding in diagnosis.findings for parameter in finding.parameters}
    assert fitted["delay"] == pytest.approx(0.05, rel=0.02)
    assert fitted["wavenumber"] == pytest.approx(12.0, rel=0.01)
    assert fitted["cosine"] == pytest.approx(3.0, rel=0.05)
    # Heard as if the drive were prompt, the wave is another wave.
    monkeypatch.setattr("mjfriction.diagnose.search.as_known.HEARD", np.inf)
    monkeypatch.setattr("mjfriction.diagnose.causes.delay._Delay.of_sensor", False)
    prompt = run(tmp_path / "prompt", machine, seed=5)
    assert set(names(prompt)) != both


def test_less_than_a_sample_late_is_refitted_and_no_finding(tmp_path: Path) -> None:
    diagnosis = run(tmp_path, Machine(hidden={j: late(0.0035) for j in range(6)}, noise=0.02), seed=5)
    assert diagnosis.findings == ()
    assert [entry.what for entry in diagnosis.adjustments] == ["delay"]
    assert diagnosis.robot.table.joint[1].effort_sensor.delay == pytest.approx(0.0035, abs=0.0005)


def test_no_filter_of_a_drive_makes_an_effort_come_early(tmp_path: Path) -> None:
    """Late by 2 ms is what drives are; early by as much, at a millisecond from row to row, is a recorder's delay."""
    found = []
    for seconds in (0.002, -0.002):
        machine = Machine(hidden={j: late(seconds) for j in range(6)}, noise=0.02)
        log, robot = write_case(tmp_path / f"{seconds}", machine, 5, seconds=20.0, rate=1000.0)
        found.append([(one.cause, one.joint) for one in diagnose_log(read_log(log), read_robot(robot)).findings])
    assert found == [[], [("sensor.delay", None)]]


def test_a_sliding_joint_of_an_mjcf_model_reads_in_newtons(tmp_path: Path) -> None:
    def bare(model: mujoco.MjModel) -> None:
        model.dof_damping[:] = 0.0  # the machine's friction is its own formula, not the model file's

    machine = Machine(
        model=read_robot("linear_axis").model_path,
        joints=("axis",),
        coulomb=(25.0,),
        viscous=(180.0,),
        hidden={0: lambda i: 40.0 * np.abs(i.v)},
        change=bare,
    )
    diagnosis = run(tmp_path, machine, seed=4)
    assert names(diagnosis) == [("friction.asymmetry", "axis")]
    (fitted,) = diagnosis.findings[0].parameters
    assert fitted.unit == "N·s/m"
    assert fitted.low < 40.0 < fitted.high
    assert diagnosis.joints[0].unit == "N"


@pytest.mark.deep
def test_heavier_links_are_no_payload(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def stout(model: mujoco.MjModel) -> None:
        body = model.body("upper_arm_link").id
        model.body_mass[body] *= 1.25
        model.body_inertia[body] *= 1.25

    diagnosis = run(tmp_path, Machine(change=stout), seed=5)
    assert [finding.cause for finding in diagnosis.findings] == ["body.link_inertia"]
    (scale,) = diagnosis.findings[0].parameters
    assert scale.name == "link_scale.shoulder_lift_joint"
    assert scale.value == pytest.approx(1.25, abs=0.05)
    # What is merely refitted along stays within what stated links are ever off by.
    known = nuisance.make_nuisance(diagnosis.gap)
    usual = np.array([refitted.LINK_SCALE, *[refitted.LINK_SHIFT] * 3])

    def farthest() -> float:
        return float(np.max(np.abs(build_model(diagnosis.gap, known, ()).link_changes) / usual))

    assert farthest() < 1.1 * nuisance.FARTHEST
    monkeypatch.setattr(nuisance, "FARTHEST", np.inf)
    assert farthest() > 2.0 * 3.0
