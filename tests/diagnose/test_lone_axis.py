"""A joint alone: what its link's inertia is off by, nothing else can tell from its rotor's."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pyarrow as pa
import pytest

from mjfriction.benchmark.cases import Setting, draw_of, make_case
from mjfriction.benchmark.drawing import draw_case
from mjfriction.diagnose.diagnosis import diagnose_log
from mjfriction.plant.machine import simulate
from mjfriction.plant.motions import excitation
from mjfriction.plant.sensors import Recorder
from mjfriction.record.readers.table import log_from_table
from mjfriction.robot.files import read_robot
from mjfriction.robot.friction_tables import FrictionTerm, WarmUp
from mjfriction.robot.robot import Robot
from tests.deep import deep
from tests.diagnose.test_planar_arm import JOINT, LINK

COULOMB = 0.8


def pendulum(
    folder: Path,
    name: str,
    *,
    inertia: float,
    rotor: float,
    coulomb: float,
    noise: float = 0.1,
    mass: float = 4.0,
    viscous: float = 0.2,
) -> Robot:
    link = LINK.format(name="rod", mass=mass, centre=-0.25, inertia=inertia)
    joint = JOINT.format(name="swing", parent="base", child="rod", z=0.0)
    (folder / f"{name}.urdf").write_text(f'<robot name="pendulum"><link name="base"/>{link}{joint}</robot>')
    (folder / f"{name}.toml").write_text(
        f'name = "{name}"\nmodel = "{name}.urdf"\n[[joint]]\nname = "swing"\n'
        f"actuator = {{ gear_ratio = 100.0, rotor_inertia = {rotor} }}\n"
        f"position_sensor = {{ resolution = 2e-5 }}\neffort_sensor = {{ noise = {noise} }}\n"
        f'friction = {{ law = "coulomb_viscous", parameters = {{ coulomb = {coulomb}, viscous = {viscous} }} }}\n'
    )
    return read_robot(folder / f"{name}.toml")


@pytest.mark.deep
@pytest.mark.parametrize(
    ("inertia", "stated_rotor", "rotor", "told"), [(0.094, 2e-6, 2e-6, False), (0.08, 1e-5, 2e-5, True)]
)
def test_a_rotor_is_told_where_no_link_a_little_off_explains_it(
    inertia: float, stated_rotor: float, rotor: float, *, told: bool, tmp_path: Path
) -> None:
    """The rod's inertia about its centre 18 % off is 4 % of what the drive turns; the rotor twice as heavy is 23 %."""
    stated = pendulum(tmp_path, "stated", inertia=0.08, rotor=stated_rotor, coulomb=COULOMB)
    machine = pendulum(tmp_path, "machine", inertia=inertia, rotor=rotor, coulomb=1.6 * COULOMB)
    motion = excitation(("swing",), np.zeros(1), np.full(1, 1.2), np.full(1, 4.0), 40.0, seed=3)
    columns = simulate(machine, motion, recorder=Recorder(250.0), controller_robot=stated, seed=1)
    found = diagnose_log(log_from_table(pa.table(columns), "swing"), stated)
    causes = {finding.cause for finding in found.findings}
    assert "friction.coulomb_viscous" in causes
    assert ("drive.rotor_inertia" in causes) is told


@pytest.mark.deep
def test_a_drive_a_little_off_is_no_finding_beside_a_level_that_is(tmp_path: Path) -> None:
    stated = pendulum(tmp_path, "stated", inertia=0.08, rotor=6e-5, coulomb=COULOMB)
    machine = pendulum(tmp_path, "machine", inertia=0.08, rotor=6.6e-5, coulomb=1.6 * COULOMB)
    motion = excitation(("swing",), np.zeros(1), np.full(1, 1.2), np.full(1, 4.0), 40.0, seed=3)
    columns = simulate(machine, motion, recorder=Recorder(250.0), controller_robot=stated, seed=1)
    columns["effort.swing"] = 1.035 * columns["effort.swing"]
    found = diagnose_log(log_from_table(pa.table(columns), "swing"), stated)
    assert [finding.cause for finding in found.findings] == ["friction.coulomb_viscous"]
    assert {change.what for change in found.adjustments} >= {"rotor_inertia", "factor"}


@pytest.mark.deep
def test_a_torque_constant_is_told_beside_levels_that_are_as_stated_with_it(tmp_path: Path) -> None:
    """All that the drive reports is 7 % less: no link, rotor and levels that happen to be off by as much."""
    robot = pendulum(tmp_path, "stated", inertia=0.08, rotor=6e-5, coulomb=COULOMB)
    motion = excitation(("swing",), np.zeros(1), np.full(1, 1.2), np.full(1, 4.0), 40.0, seed=3)
    columns = simulate(robot, motion, recorder=Recorder(250.0), seed=1)
    columns["effort.swing"] = 0.93 * columns["effort.swing"]
    (finding,) = diagnose_log(log_from_table(pa.table(columns), "swing"), robot).findings
    assert finding.cause == "drive.torque_constant"
    assert finding.parameters[0].value == pytest.approx(0.93, abs=0.01)


@pytest.mark.parametrize(
    ("cause", "of_all", "of_link"), [("drive.torque_constant", 0.92, 1.0), deep("body.link_inertia", 1.0, 0.9)]
)
def test_one_number_explains_more_than_several_that_are_off_alike(
    cause: str, of_all: float, of_link: float, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Without a rotor, free levels beside a free link leave nothing of a torque constant; and beside a torque constant,
    levels that undo it leave nothing of a link.
    """
    stated = pendulum(tmp_path, "stated", inertia=0.08, rotor=0.0, coulomb=COULOMB)
    machine = pendulum(tmp_path, "machine", inertia=of_link * 0.08, rotor=0.0, coulomb=COULOMB, mass=of_link * 4.0)
    motion = excitation(("swing",), np.zeros(1), np.full(1, 1.2), np.full(1, 4.0), 40.0, seed=3)
    columns = simulate(machine, motion, recorder=Recorder(250.0), controller_robot=stated, seed=1)
    columns["effort.swing"] = of_all * columns["effort.swing"]
    log = log_from_table(pa.table(columns), "swing")
    (finding,) = diagnose_log(log, stated).findings
    assert finding.cause == cause
    assert finding.parameters[0].value == pytest.approx(of_all * of_link, abs=0.01)
    monkeypatch.setattr("mjfriction.diagnose.settle.stated.one_number", lambda model: model)
    assert cause not in {finding.cause for finding in diagnose_log(log, stated).findings}


@pytest.mark.deep
def test_a_torque_constant_is_told_beside_a_delay(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Beside a late effort, levels look off by various shares at first, and the drive's data sheet is in doubt."""
    stated = pendulum(tmp_path, "stated", inertia=0.08, rotor=6e-5, coulomb=COULOMB)
    motion = excitation(("swing",), np.zeros(1), np.full(1, 1.2), np.full(1, 4.0), 40.0, seed=3)
    columns = simulate(stated, motion, recorder=Recorder(250.0), seed=1)
    late = np.interp(columns["time"] - 0.016, columns["time"], columns["effort.swing"])
    columns["effort.swing"] = 0.92 * late
    log = log_from_table(pa.table(columns), "swing")
    found = {finding.cause: finding.parameters[0].value for finding in diagnose_log(log, stated).findings}
    assert found.keys() == {"drive.torque_constant", "sensor.delay"}
    assert found["drive.torque_constant"] == pytest.approx(0.92, abs=0.01)
    assert found["sensor.delay"] == pytest.approx(0.016, abs=0.002)
    monkeypatch.setattr("mjfriction.diagnose.settle.stated.one_number", lambda model: model)
    assert [finding.cause for finding in diagnose_log(log, stated).findings] == ["sensor.delay"]


@pytest.mark.deep
def test_a_link_a_tenth_off_is_no_finding_where_nothing_tells_how_far_friction_is(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Friction that changes as the joint warms is as stated at some moment.  A joint alone does not show whether its
    link or its torque constant is off, and both may be by some percent.
    """
    stated = pendulum(tmp_path, "stated", inertia=0.08, rotor=0.0, coulomb=COULOMB)
    light = pendulum(tmp_path, "machine", inertia=0.9 * 0.08, rotor=0.0, coulomb=COULOMB, mass=0.9 * 4.0)
    warm_up = WarmUp(coulomb=-0.5 * COULOMB, viscous=0.0, time_constant=12.0, begin=0.0)
    machine = light.with_joint(light.table.joint[0].model_copy(update={"warm_up": warm_up}))
    motion = excitation(("swing",), np.zeros(1), np.full(1, 1.2), np.full(1, 4.0), 40.0, seed=3)
    columns = simulate(machine, motion, recorder=Recorder(250.0), controller_robot=stated, seed=1)
    log = log_from_table(pa.table(columns), "swing")
    causes = [finding.cause for finding in diagnose_log(log, stated).findings]
    assert causes == ["friction.temperature"]
    monkeypatch.setattr("mjfriction.diagnose.tell.link_finding.FEWEST_JOINTS", 1)
    assert "body.link_inertia" in {finding.cause for finding in diagnose_log(log, stated).findings}


@pytest.mark.parametrize(("friction", "viscous"), [(1.0, 0.2), (1.0, 0.0), (1.03, 0.2)])
def test_a_link_a_few_percent_off_is_told_where_friction_is_surely_as_stated(
    friction: float, viscous: float, tmp_path: Path
) -> None:
    """Where friction is 3 % off, so may the torque constant be, and masses are hardly stated better."""
    alike = {"rotor": 0.0, "noise": 0.02, "viscous": viscous}
    stated = pendulum(tmp_path, "stated", inertia=0.08, coulomb=COULOMB, **alike)
    machine = pendulum(tmp_path, "machine", inertia=1.065 * 0.08, coulomb=friction * COULOMB, mass=4.26, **alike)
    motion = excitation(("swing",), np.zeros(1), np.full(1, 1.2), np.full(1, 4.0), 40.0, seed=3)
    columns = simulate(machine, motion, recorder=Recorder(250.0), controller_robot=stated, seed=1)
    found = diagnose_log(log_from_table(pa.table(columns), "swing"), stated)
    assert {finding.cause for finding in found.findings} == ({"body.link_inertia"} if friction == 1.0 else set())
    for finding in found.findings:
        assert finding.parameters[0].value == pytest.approx(1.065, abs=0.005)
        assert "body.payload" in finding.alternatives


@pytest.mark.deep
def test_play_of_centimetres_on_a_slide_is_judged_on_the_real_balance() -> None:
    """The link flies for a tenth of a second: near a play of 23 mm no straight line says where it lands."""
    setting = Setting(robot="linear_axis", seconds=30.0, rate=250.0, noise=0.2, encoder=1.9e-4)
    case = make_case(8, setting, (draw_of("drive.backlash"),), 4.0)
    (finding,) = diagnose_log(log_from_table(pa.table(case.log), "slide"), case.stated).findings
    assert finding.cause == "drive.backlash"
    assert finding.parameters[0].value == pytest.approx(case.hidden[0].strength, rel=0.02)


@pytest.mark.deep
def test_a_heavier_rod_may_be_a_load_at_its_end(tmp_path: Path) -> None:
    stated = pendulum(tmp_path, "stated", inertia=0.08, rotor=6e-5, coulomb=COULOMB)
    machine = pendulum(tmp_path, "machine", inertia=0.16, rotor=6e-5, coulomb=COULOMB, mass=8.0)
    motion = excitation(("swing",), np.zeros(1), np.full(1, 1.2), np.full(1, 4.0), 40.0, seed=3)
    columns = simulate(machine, motion, recorder=Recorder(250.0), controller_robot=stated, seed=1)
    (finding,) = diagnose_log(log_from_table(pa.table(columns), "swing"), stated).findings
    assert {finding.cause, *finding.alternatives} >= {"body.link_inertia", "body.payload"}


@pytest.mark.deep
@pytest.mark.parametrize("wave", [0.0, 0.18])
def test_what_is_small_is_told_of_a_lone_axis_where_what_is_left_says_that_it_is_even(
    wave: float, tmp_path: Path
) -> None:
    """An offset of 6 % of friction; a machine with waves of as much each along its stroke is uneven."""
    robot = pendulum(tmp_path, "stated", inertia=0.08, rotor=6e-5, coulomb=3.0, noise=0.02)
    motion = excitation(("swing",), np.zeros(1), np.full(1, 1.2), np.full(1, 4.0), 40.0, seed=3)
    columns = simulate(robot, motion, recorder=Recorder(250.0), seed=1)
    position, direction = columns["position.swing"], np.sign(np.gradient(columns["position.swing"]))
    uneven = sum(np.cos(wavenumber * position + wavenumber) for wavenumber in (4.0, 7.0, 11.0, 17.0))
    columns["effort.swing"] = columns["effort.swing"] + 0.18 + wave * direction * uneven
    causes = {finding.cause for finding in diagnose_log(log_from_table(pa.table(columns), "swing"), robot).findings}
    assert ("drive.offset" in causes) is (wave == 0.0)


def test_a_lone_pendulum_on_a_tilted_base_is_not_left_open(tmp_path: Path) -> None:
    """Of a tilt it sees one direction, which is as good as its zero; the other is nothing to it, however bent."""
    stated = pendulum(tmp_path, "stated", inertia=0.08, rotor=6e-5, coulomb=COULOMB)
    tilted = (-9.81 * np.sin(0.16), 0.0, -9.81 * np.cos(0.16))
    machine = Robot(stated.table.model_copy(update={"gravity": tilted}), stated.folder)
    motion = excitation(("swing",), np.zeros(1), np.full(1, 1.2), np.full(1, 4.0), 40.0, seed=3)
    columns = simulate(machine, motion, recorder=Recorder(250.0), controller_robot=stated, seed=1)
    found = diagnose_log(log_from_table(pa.table(columns), "swing"), stated)
    (finding,) = found.findings
    assert {finding.cause, *finding.alternatives} >= {"body.gravity_direction", "sensor.encoder_offset"}
    assert found.joints[0].rms_heldout_after < 1.1 * found.joints[0].noise_floor


def test_a_zero_is_like_a_tilt_beside_friction_that_differs_by_direction_too() -> None:
    """Friction that differs between the directions asks for an offset by name; it is one of several all the same."""
    level = {"coulomb": 40.0, "viscous": 200.0}
    ways = {f"{name}_{way}": value for name, value in level.items() for way in ("positive", "negative")}
    ways |= {"viscous_positive": 260.0, "viscous_negative": 140.0}
    bare = read_robot("linear_axis")
    axis = bare.joint("axis")
    stated, machine = (
        bare.with_joint(axis.model_copy(update={"friction": (FrictionTerm(law=law, parameters=values),)}))
        for law, values in (("coulomb_viscous", level), ("asymmetric", ways))
    )
    machine = Robot(machine.table.model_copy(update={"gravity": (-0.5, 0.0, -9.797)}), machine.folder)
    motion = excitation(("axis",), np.zeros(1), np.full(1, 0.15), np.full(1, 0.4), 40.0, seed=2)
    columns = simulate(machine, motion, recorder=Recorder(250.0), controller_robot=stated, seed=1)
    found = diagnose_log(log_from_table(pa.table(columns), "slide"), stated)
    named = [{finding.cause, *finding.alternatives} for finding in found.findings]
    assert {"friction.asymmetry"} in named
    assert any({"drive.offset", "body.gravity_direction"} <= one for one in named)


@pytest.mark.deep
def test_a_rotor_twice_as_heavy_is_told_beside_levels_that_are_off() -> None:
    """A torque constant may be off in the place of the levels. Without the rotor, levels that make up for it would have
    to be off as far as they never are.
    """
    case = draw_case(970091).case()
    assert [hidden.cause for hidden in case.hidden] == ["drive.rotor_inertia", "friction.coulomb_viscous"]
    found = diagnose_log(log_from_table(pa.table(case.log), "axis"), case.stated)
    named = [{finding.cause, *finding.alternatives} for finding in found.findings]
    assert len(named) == 2
    assert any("drive.rotor_inertia" in own for own in named)
    assert any("friction.coulomb_viscous" in own for own in named)


@pytest.mark.deep
def test_play_is_told_though_it_shows_in_few_rows(tmp_path: Path) -> None:
    """Nothing tells how uneven a joint alone is, so that an effect must be large. Play is, where the link lands."""
    stated = pendulum(tmp_path, "stated", inertia=0.08, rotor=6e-5, coulomb=9.0, noise=0.3)
    (swing,) = stated.table.joint
    played = swing.model_copy(update={"transmission": swing.transmission.model_copy(update={"backlash": 0.01})})
    motion = excitation(("swing",), np.zeros(1), np.full(1, 1.2), np.full(1, 0.4), 60.0, seed=3)
    columns = simulate(stated.with_joint(played), motion, recorder=Recorder(250.0), seed=1)
    (finding,) = diagnose_log(log_from_table(pa.table(columns), "swing"), stated).findings
    assert finding.cause == "drive.backlash"
    assert finding.parameters[0].value == pytest.approx(0.01, rel=0.2)


def test_friction_that_builds_up_within_a_short_travel_is_told_of_a_joint_alone(tmp_path: Path) -> None:
    """On an arm, where other joints would show it too, it is what any contact yields."""
    stated = pendulum(tmp_path, "stated", inertia=0.08, rotor=6e-5, coulomb=COULOMB, noise=0.2)
    swing = stated.table.joint[0]
    values = {"coulomb": COULOMB, "bristle_stiffness": COULOMB / 1e-4, "shape_exponent": 1.0, "viscous": 0.2}
    level = FrictionTerm(law="dahl", parameters=values)
    motion = excitation(("swing",), np.zeros(1), np.full(1, 0.02), np.full(1, 0.2), 30.0, seed=3, band=(0.5, 2.0))
    machine = stated.with_joint(swing.model_copy(update={"friction": (level,)}))
    columns = simulate(machine, motion, recorder=Recorder(500.0), controller_robot=stated, seed=1)
    (finding,) = diagnose_log(log_from_table(pa.table(columns), "swing"), stated).findings
    assert finding.cause == "friction.presliding"
    assert finding.parameters[1].value == pytest.approx(1e-4, rel=0.1)
