"""A cause that was chosen before others were known gives its place to what fits better there, now that they are."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pyarrow as pa
import pytest

from mjfriction.diagnose.causes.catalog import STRUCTURAL
from mjfriction.diagnose.causes.cause import Site
from mjfriction.diagnose.causes.links import LinkScale
from mjfriction.diagnose.causes.payload import Payload
from mjfriction.diagnose.causes.rotor_inertia import RotorInertia
from mjfriction.diagnose.fit.model import Chosen, Model, build_model
from mjfriction.diagnose.fit.nuisance import make_nuisance
from mjfriction.diagnose.fit.tangent import straightened
from mjfriction.diagnose.search import exchange as exchange_module
from mjfriction.diagnose.search.compete import NO_DIFFERENCE
from mjfriction.diagnose.search.exchange import Kinds, exchanged
from mjfriction.diagnose.search.field import Field, chances_in, make_field
from mjfriction.diagnose.tell.alike import standing
from mjfriction.identify.measure import measure_gap
from mjfriction.plant.machine import simulate
from mjfriction.plant.motions import excitation
from mjfriction.plant.sensors import Recorder
from mjfriction.record.readers.table import log_from_table
from mjfriction.robot.files import read_robot
from mjfriction.robot.robot import Robot
from tests.diagnose.test_planar_arm import JOINT, LINK

UPPER, ELBOW_ROTOR = 2.0, 0.03  # kg, kg·m²
LOAD = Chosen(Payload(), Site(1))
ROTOR = Chosen(RotorInertia(), Site(1))


def two_links(folder: Path, upper: float, rotor: float) -> Robot:
    folder.mkdir()
    (folder / "arm.urdf").write_text(
        '<robot name="arm"><link name="base"/>'
        + LINK.format(name="upper", mass=upper, centre=-0.2, inertia=0.01 * upper)
        + LINK.format(name="fore", mass=1.2, centre=-0.2, inertia=0.01)
        + JOINT.format(name="shoulder", parent="base", child="upper", z=0.0)
        + JOINT.format(name="elbow", parent="upper", child="fore", z=-0.4)
        + "</robot>"
    )
    joints = "".join(
        f'[[joint]]\nname = "{name}"\nposition_sensor = {{ resolution = 2e-5 }}\neffort_sensor = {{ noise = 0.02 }}\n'
        f"actuator = {{ rotor_inertia = {inertia} }}\n"
        'friction = { law = "coulomb_viscous", parameters = { coulomb = 0.2, viscous = 0.1 } }\n'
        for name, inertia in (("shoulder", ELBOW_ROTOR), ("elbow", rotor))
    )
    (folder / "robot.toml").write_text(f'name = "arm"\nmodel = "arm.urdf"\n{joints}')
    return read_robot(folder / "robot.toml")


@pytest.fixture(scope="module")
def mistaken(tmp_path_factory: pytest.TempPathFactory) -> tuple[Model, Field]:
    """An arm whose upper link and elbow's rotor are heavier than stated, for which a load and the rotor were chosen."""
    folder = tmp_path_factory.mktemp("arms")
    stated = two_links(folder / "stated", UPPER, ELBOW_ROTOR)
    machine = two_links(folder / "machine", 1.5 * UPPER, 2.0 * ELBOW_ROTOR)
    motion = excitation(stated.joints, np.zeros(2), np.full(2, 1.2), np.full(2, 2.0), 30.0, seed=3)
    columns = simulate(machine, motion, recorder=Recorder(250.0), controller_robot=stated, seed=1)
    gap = measure_gap(log_from_table(pa.table(columns), "arm"), stated)
    return straightened(build_model(gap, make_nuisance(gap), (LOAD, ROTOR))), make_field(gap, STRUCTURAL)


def test_the_heavier_link_takes_the_place_of_the_load_that_stood_for_it(mistaken: tuple[Model, Field]) -> None:
    model, field = mistaken
    exchange = exchanged(model, field, chances_in(field), NO_DIFFERENCE)
    assert exchange is not None
    other = exchange.model
    assert {(type(choice.cause), choice.site.joint) for choice in other.chosen} == {(RotorInertia, 1), (LinkScale, 0)}
    (place,) = (at for choice, at in zip(other.chosen, other.places, strict=True) if choice.key != ROTOR.key)
    assert other.strengths[place][0] == pytest.approx(0.5, rel=0.05)
    assert np.sum(other.heldout_errors) < np.sum(model.heldout_errors)


def test_the_right_causes_keep_their_places(mistaken: tuple[Model, Field]) -> None:
    model, field = mistaken
    right = build_model(model.gap, model.nuisance, (ROTOR, Chosen(LinkScale(), Site(0))))
    assert exchanged(right, field, chances_in(field), NO_DIFFERENCE) is None


def test_no_exchange_is_made_twice(mistaken: tuple[Model, Field]) -> None:
    # The search after it may lead back to what there was, again and again.
    model, field = mistaken
    made: list[Kinds] = []
    while (exchange := exchanged(model, field, chances_in(field), NO_DIFFERENCE, made)) is not None:
        assert exchange.kinds not in made
        made.append(exchange.kinds)
    assert ((Payload, 1), (LinkScale, 0)) in made


def test_a_lone_cause_keeps_its_place(mistaken: tuple[Model, Field]) -> None:
    # It won against all the others already.
    model, field = mistaken
    assert exchanged(model.without(ROTOR), field, chances_in(field), NO_DIFFERENCE) is None


def test_a_rival_is_named_however_far_the_cause_takes_the_links_from_where_they_were_drawn(
    mistaken: tuple[Model, Field],
) -> None:
    # What the load takes off the strain of links is more than all that was left: no measure of what it leaves.
    model, field = mistaken
    stands = standing(model, model.chosen[0], field)
    assert stands.alternatives == ("body.link_inertia",)
    assert stands.confidence == pytest.approx(0.5)


def test_none_of_a_long_list_is_exchanged(mistaken: tuple[Model, Field], monkeypatch: pytest.MonkeyPatch) -> None:
    model, field = mistaken
    monkeypatch.setattr(exchange_module, "MOST_EXCHANGED", 1)
    assert exchanged(model, field, chances_in(field), NO_DIFFERENCE) is None
