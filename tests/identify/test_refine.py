"""Refinement on simulated motion, where a coarse encoder makes accelerations worthless."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pyarrow as pa
import pytest

from mjfriction.errors import LawError, RobotError
from mjfriction.identify.fit import with_known
from mjfriction.identify.identification import identify_log
from mjfriction.laws.catalog import LAWS, find_law
from mjfriction.laws.rules import Values
from mjfriction.plant.machine import simulate
from mjfriction.plant.motions import excitation
from mjfriction.plant.sensors import Recorder
from mjfriction.record.readers.table import log_from_table
from mjfriction.robot.files import read_robot
from mjfriction.robot.robot import Robot
from tests.deep import deep
from tests.robot.test_friction_terms import URDF

COULOMB, VISCOUS = 2.0, 0.8


def robot_with(folder: Path, coulomb: float, viscous: float, more: str = "") -> Robot:
    (folder / "one.urdf").write_text(URDF)
    (folder / "robot.toml").write_text(
        'name = "one"\nmodel = "one.urdf"\n[[joint]]\nname = "hinge"\n'
        f'friction = {{ law = "coulomb_viscous", parameters = {{ coulomb = {coulomb}, viscous = {viscous} }} }}\n{more}'
    )
    return read_robot(folder / "robot.toml")


def recorded(folder: Path, seconds: float = 30.0, rate: float = 500.0):
    real = robot_with(folder, COULOMB, VISCOUS, "position_sensor = { resolution = 0.006 }\n")
    motion = excitation(("hinge",), np.zeros(1), np.ones(1), np.full(1, 3.0), seconds, seed=4)
    return log_from_table(pa.table(simulate(real, motion, recorder=Recorder(rate), seed=1)), "coarse")


@pytest.fixture(scope="module")
def short(tmp_path_factory: pytest.TempPathFactory):
    return recorded(tmp_path_factory.mktemp("short"), 15.0, 250.0)


@pytest.mark.deep
def test_refinement_brings_the_open_loop_simulation_back_to_the_log(tmp_path: Path) -> None:
    found = identify_log(recorded(tmp_path), robot_with(tmp_path, 1.0, 1.0), law="coulomb_viscous", simulated=np.inf)
    assert found.simulated is not None
    assert found.simulated.after[0] < 0.3 * found.simulated.before[0]
    (law,) = found.laws
    values = {fitted.name: fitted for fitted in law.parameters}
    assert values["coulomb"].value == pytest.approx(COULOMB, rel=0.01)
    assert values["viscous"].value == pytest.approx(VISCOUS, rel=0.02)
    assert found.robot.joint("hinge").friction[0].parameters["coulomb"] == pytest.approx(values["coulomb"].value)
    assert "Simulated freely for 30 s" in found.summary


def test_a_coarse_encoder_does_not_make_the_intervals_useless(tmp_path: Path) -> None:
    (law,) = identify_log(recorded(tmp_path), robot_with(tmp_path, 1.0, 1.0), law="coulomb_viscous").laws
    for fitted, truth in zip(law.parameters, (COULOMB, VISCOUS), strict=True):
        assert fitted.low < truth < fitted.high
        assert fitted.high - fitted.low < 0.1 * truth


def test_the_true_robot_goes_where_the_log_says(tmp_path: Path) -> None:
    # A step too early or too late, or an effort held half a step off, would leave some 1e-3 rad.
    real = robot_with(tmp_path, COULOMB, VISCOUS)
    motion = excitation(("hinge",), np.zeros(1), np.ones(1), np.full(1, 3.0), 12.0, seed=4)
    log = log_from_table(pa.table(simulate(real, motion, recorder=Recorder(250.0), seed=1)), "fine")
    found = identify_log(log, real, law="coulomb_viscous", simulated=1.0)
    assert found.simulated is not None
    assert found.simulated.before[0] < 3e-4
    for fitted, truth in zip(found.laws[0].parameters, (COULOMB, VISCOUS), strict=True):
        assert fitted.value == pytest.approx(truth, rel=5e-3)
        assert fitted.low < truth < fitted.high


def test_what_the_log_says_nothing_of_is_not_known_exactly(tmp_path: Path) -> None:
    found = identify_log(recorded(tmp_path), robot_with(tmp_path, 1.0, 1.0), law="temperature_dependent")
    values = {fitted.name: fitted for fitted in found.laws[0].parameters}
    assert values["viscous_decay"].note == "this log does not show it"
    # Of the link a hinge about a vertical axis shows the moment about that, and nothing else.
    assert [fitted.name for fitted in found.background] == ["zz.hinge", "offset.hinge"]


@pytest.mark.parametrize("seconds", [0.0, -1.0, float("nan"), 0.01])
def test_stretches_of_no_length_are_refused(seconds: float, tmp_path: Path) -> None:
    with pytest.raises(RobotError, match="no stretch to simulate"):
        identify_log(recorded(tmp_path), robot_with(tmp_path, 1.0, 1.0), law="coulomb", simulated=seconds)


@pytest.mark.deep
def test_what_the_model_does_not_hold_is_played_along(tmp_path: Path) -> None:
    cogged = "cogging = [ { wavenumber = 8.0, cosine = 0.6, sine = 0.0 } ]\n"
    real = robot_with(tmp_path, COULOMB, VISCOUS, cogged)
    motion = excitation(("hinge",), np.zeros(1), np.ones(1), np.full(1, 3.0), 12.0, seed=4)
    log = log_from_table(pa.table(simulate(real, motion, recorder=Recorder(250.0), seed=1)), "cogged")
    found = identify_log(log, robot_with(tmp_path, 1.0, 1.0, cogged), law="coulomb_viscous", simulated=1.0)
    for fitted, truth in zip(found.laws[0].parameters, (COULOMB, VISCOUS), strict=True):
        assert fitted.value == pytest.approx(truth, rel=5e-3)
    assert found.simulated is not None
    assert found.simulated.after[0] < 3e-4
    without = identify_log(log, robot_with(tmp_path, 1.0, 1.0), law="coulomb_viscous", simulated=1.0)
    assert without.simulated is not None
    assert without.simulated.after[0] > 10.0 * found.simulated.after[0]


@pytest.mark.deep
def test_a_late_effort_is_played_when_it_acted(tmp_path: Path) -> None:
    late = "effort_sensor = { delay = 0.02 }\n"
    real = robot_with(tmp_path, COULOMB, VISCOUS, late)
    motion = excitation(("hinge",), np.zeros(1), np.ones(1), np.full(1, 3.0), 12.0, seed=4)
    log = log_from_table(pa.table(simulate(real, motion, recorder=Recorder(250.0), seed=1)), "late")
    known = identify_log(log, robot_with(tmp_path, COULOMB, VISCOUS, late), law="coulomb_viscous", simulated=1.0)
    unknown = identify_log(log, robot_with(tmp_path, COULOMB, VISCOUS), law="coulomb_viscous", simulated=1.0)
    assert known.simulated is not None
    assert unknown.simulated is not None
    assert known.simulated.before[0] < 0.2 * unknown.simulated.before[0]
    for fitted, truth in zip(known.laws[0].parameters, (COULOMB, VISCOUS), strict=True):
        assert fitted.value == pytest.approx(truth, rel=0.01)


@pytest.mark.deep
def test_a_piece_too_short_for_a_stretch_is_left_out(tmp_path: Path) -> None:
    whole = recorded(tmp_path)
    # A segment of a third of a second at the end: too short to be simulated for a second, long enough to be fitted.
    segment = np.where(whole.time > 29.6, 1, 0)
    split = dataclasses.replace(whole, segment=segment)
    stated = robot_with(tmp_path, 1.0, 1.0)
    found = [identify_log(log, stated, law="coulomb_viscous", simulated=1.0) for log in (whole, split)]
    for identification in found:
        assert identification.simulated is not None
        values = {fitted.name: fitted.value for fitted in identification.laws[0].parameters}
        assert values["coulomb"] == pytest.approx(COULOMB, rel=0.02)


@pytest.mark.parametrize("law", [deep(law) if law == "leuven" else law for law in LAWS])
def test_every_law_can_be_fitted(law: str, short, tmp_path: Path) -> None:
    found = identify_log(short, robot_with(tmp_path, 1.0, 1.0), law=law)
    (fitted,) = found.laws
    assert fitted.fit.law.name == law
    assert all(np.isfinite([p.value, p.low, p.high]).all() or p.note for p in fitted.parameters)
    (error,) = found.joints
    # Plain friction is in each of them, so that none may do worse than the stated one, which is half of what it was.
    assert error.rms_heldout_after < 0.8 * error.rms_before


@pytest.mark.deep
def test_six_joints_that_were_read_coarsely_are_brought_back_to_the_log(tmp_path: Path) -> None:
    # Encoders of a step of 0.3 degrees: nothing of an acceleration is left, but where efforts lead still is.
    stated = read_robot("ur5")
    machine = stated
    for joint in stated.table.joint:
        (term,) = joint.friction or ()
        more = {name: 1.3 * term.value(name) for name in term.parameters}
        sensor = joint.position_sensor.model_copy(update={"resolution": 0.005})
        term = term.model_copy(update={"parameters": more})
        machine = machine.with_joint(joint.model_copy(update={"friction": (term,), "position_sensor": sensor}))
    middle = np.array([0.0, -1.2, 1.2, -0.5, 0.5, 0.0])
    motion = excitation(stated.joints, middle, np.full(6, 0.8), np.full(6, 1.5), 30.0, seed=4)
    log = log_from_table(pa.table(simulate(machine, motion, recorder=Recorder(250.0), seed=1)), "six")
    found = identify_log(log, stated, law="coulomb_viscous", links=False, simulated=0.5)
    assert found.simulated is not None
    assert np.all(found.simulated.after < found.simulated.before)
    for law, joint in zip(found.laws, machine.table.joint, strict=True):
        (term,) = joint.friction or ()
        for fitted in law.parameters:
            assert fitted.low < term.value(fitted.name) < fitted.high, (law.joint, fitted)
            assert fitted.value == pytest.approx(term.value(fitted.name), rel=0.1), (law.joint, fitted)


def test_what_is_known_lifts_what_has_to_be_above_it() -> None:
    # A sibling without a state may have found more friction at rest than a start has after a long one.
    law = find_law("dwell_time")
    start: Values = {
        **{"coulomb": 1.0, "static": 1.5, "static_rested": 2.0, "viscous": 1.0},
        **{"rise_time": 1.0, "stribeck_velocity": 0.1, "bristle_stiffness": 100.0},
    }
    known = {"coulomb": 1.2, "static": 3.0}
    values = with_known(law, start, known)
    law.pack(values)
    assert values == {**start, **known, "static_rested": 4.0}
    assert with_known(law, start, {"static": 1.2}) == {**start, "static": 1.2}
    with pytest.raises(LawError, match="static_rested"):
        law.pack({**start, **known})
