"""Laws with elements: springs and waves that the log shows, found with their number."""

from __future__ import annotations

import functools
from pathlib import Path

import numpy as np
import pyarrow as pa
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mjfriction.identify.coordinates import Coordinates
from mjfriction.identify.elements import elements_of_law
from mjfriction.identify.identification import identify_log
from mjfriction.identify.outcome import Identification
from mjfriction.laws.catalog import find_law
from mjfriction.laws.rules import array
from mjfriction.plant.machine import simulate
from mjfriction.plant.motions import excitation
from mjfriction.plant.sensors import Recorder
from mjfriction.record.readers.table import log_from_table
from mjfriction.robot.files import read_robot
from mjfriction.robot.robot import Robot
from tests.deep import deep
from tests.robot.test_friction_terms import URDF

NOISE = 0.02  # N·m, where friction is 2.5
SPRINGS = "stiffness = [200.0, 60.0, 10.0]"
STRIBECK = "coulomb = 1.5, static = 2.2, stribeck_velocity = 0.05, stribeck_exponent = 1.0, viscous = 0.5"
TRUTH = {
    "maxwell_slip": f"viscous = 0.5, {SPRINGS}, level = [1.0, 0.9, 0.6]",
    "gms": f"{STRIBECK}, attraction = 200.0, {SPRINGS}, share = [0.4, 0.35, 0.25]",
    "dahl": "coulomb = 2.0, viscous = 0.5, bristle_stiffness = 80.0, shape_exponent = 1.5",
    "lugre": f"{STRIBECK}, bristle_stiffness = 80.0, bristle_damping = 1.0",
    "leuven": f"{STRIBECK}, bristle_damping = 1.0, shape_exponent = 1.0, {SPRINGS}, level = [0.9, 0.8, 0.5]",
    "position_dependent": "coulomb = 1.5, viscous = 0.5, wavenumber = [12.0], cosine = [0.3], sine = [-0.2]",
}


def robot_with(folder: Path, law: str, parameters: str) -> Robot:
    (folder / "one.urdf").write_text(URDF)
    (folder / "robot.toml").write_text(
        'name = "one"\nmodel = "one.urdf"\n[[joint]]\nname = "hinge"\n'
        f'friction = {{ law = "{law}", parameters = {{ {parameters} }} }}\n'
    )
    return read_robot(folder / "robot.toml")


@pytest.fixture(scope="module")
def identified(tmp_path_factory: pytest.TempPathFactory):
    @functools.cache
    def of(truth: str, law: str) -> Identification:
        folder = tmp_path_factory.mktemp("one")
        motion = excitation(("hinge",), np.zeros(1), np.ones(1), np.ones(1), 40.0, seed=4)
        real = robot_with(folder, truth, TRUTH[truth])
        columns = simulate(real, motion, recorder=Recorder(250.0), seed=1)
        effort = columns["effort.hinge"]
        columns["effort.hinge"] = effort + np.random.default_rng(2).normal(0.0, NOISE, effort.size)
        stated = robot_with(folder, "coulomb_viscous", "coulomb = 1.0, viscous = 1.0")
        return identify_log(log_from_table(pa.table(columns), truth), stated, law=law)

    return of


@pytest.mark.deep
def test_springs_are_found_with_their_number(identified) -> None:
    found = identified("maxwell_slip", "maxwell_slip")
    values = {fitted.name: fitted for fitted in found.laws[0].parameters}
    for name, truth in (("stiffness", (200.0, 60.0, 10.0)), ("level", (1.0, 0.9, 0.6))):
        assert f"{name}[4]" not in values
        for i, value in enumerate(truth):
            fitted = values[f"{name}[{i + 1}]"]
            assert fitted.value == pytest.approx(value, rel=0.05)
            assert fitted.unit == ("N·m/rad" if name == "stiffness" else "N·m")
    plain = identified("maxwell_slip", "coulomb_viscous")
    assert found.joints[0].rms_heldout_after < 0.1 * plain.joints[0].rms_heldout_after


@pytest.mark.deep
def test_the_generalized_law_is_found_whole(identified) -> None:
    values = {fitted.name: fitted.value for fitted in identified("gms", "gms").laws[0].parameters}
    assert "share[4]" not in values
    for i, (stiffness, share) in enumerate(zip((200.0, 60.0, 10.0), (0.4, 0.35, 0.25), strict=True)):
        assert values[f"share[{i + 1}]"] == pytest.approx(share, rel=0.05)
        assert values[f"stiffness[{i + 1}]"] == pytest.approx(stiffness, rel=0.05)
    assert values["coulomb"] == pytest.approx(1.5, rel=0.02)
    assert values["attraction"] == pytest.approx(200.0, rel=0.5)
    lugre = identified("gms", "lugre").joints[0].rms_heldout_after
    assert identified("gms", "gms").joints[0].rms_heldout_after < 0.5 * lugre


@pytest.mark.parametrize(
    ("law", "truth"),
    [
        deep("dahl", {"coulomb": 2.0, "bristle_stiffness": 80.0, "shape_exponent": 1.5}),
        ("lugre", {"coulomb": 1.5, "bristle_stiffness": 80.0, "bristle_damping": 1.0}),
        deep("leuven", {"coulomb": 1.5, "bristle_damping": 1.0, "shape_exponent": 1.0}),
    ],
)
def test_a_bristle_is_found_beside_its_statics(law: str, truth: dict[str, float], identified) -> None:
    found = identified(law, law)
    values = {fitted.name: fitted.value for fitted in found.laws[0].parameters}
    for name, value in truth.items():
        assert values[name] == pytest.approx(value, rel=0.02 if name in ("coulomb", "bristle_stiffness") else 0.12), (
            name
        )
    # Nothing but the sensor's noise is left, where a law without a state leaves many times that.
    assert found.joints[0].rms_heldout_after < 1.1 * found.joints[0].noise_floor
    plain = identified(law, "stribeck")
    assert plain.joints[0].rms_heldout_after > 5.0 * found.joints[0].rms_heldout_after


def test_a_wave_of_the_level_is_found_with_its_period(identified) -> None:
    found = identified("position_dependent", "position_dependent")
    values = {fitted.name: fitted.value for fitted in found.laws[0].parameters}
    assert values["wavenumber[1]"] == pytest.approx(12.0, rel=1e-3)
    assert values["cosine[1]"] == pytest.approx(0.3, rel=0.05)
    assert values["sine[1]"] == pytest.approx(-0.2, rel=0.05)
    assert "wavenumber[2]" not in values


def test_the_identified_robot_holds_the_elements(identified, tmp_path: Path) -> None:
    found = identified("maxwell_slip", "maxwell_slip")
    (term,) = found.robot.joint("hinge").friction
    assert len(array(term.parameters, "level")) == 3
    assert term.friction(1.0).state_count == 3


LAWS = ("maxwell_slip", "leuven", "gms", "position_dependent")


@settings(max_examples=30, deadline=None)
@given(data=st.data(), name=st.sampled_from(LAWS), count=st.integers(1, 5))
def test_free_numbers_are_a_law_and_back(data: st.DataObject, name: str, count: int) -> None:
    law = find_law(name)
    elements = elements_of_law(law, count)
    single = tuple(parameter.name for parameter in law.parameters)
    coordinates = Coordinates(law, single, {}, elements)
    low, high = coordinates.bounds()
    x = np.array([data.draw(st.floats(max(-3.0, a), min(3.0, b))) for a, b in zip(low, high, strict=True)])
    values = coordinates.values(x)
    packed = law.pack(values)  # what the law allows, its elements in the order in which they break away
    again = coordinates.values(coordinates.vector(values))
    np.testing.assert_allclose(law.pack(again), packed, rtol=1e-9, atol=1e-12)
    told = coordinates.told(x)
    assert coordinates.slopes(x).shape == (len(told), x.size)
