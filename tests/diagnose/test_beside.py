"""Causes beside others: drawn with what is known of body and stroke, and refused where another leaves what looks like
them.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from mjfriction.diagnose.causes.backlash import Backlash
from mjfriction.diagnose.causes.cause import Site
from mjfriction.diagnose.causes.delay import JointDelay
from mjfriction.diagnose.causes.encoder_offset import EncoderOffset
from mjfriction.diagnose.causes.links import LinkScale
from mjfriction.diagnose.causes.load import Load
from mjfriction.diagnose.causes.rotor_inertia import RotorInertia
from mjfriction.diagnose.diagnosis import diagnose_log
from mjfriction.diagnose.fit.model import Chosen, build_model, same_columns
from mjfriction.diagnose.fit.nuisance import make_nuisance
from mjfriction.diagnose.search.refusal import _of_landings
from mjfriction.identify.gap import Gap
from mjfriction.identify.measure import gap_of, measure_gap
from mjfriction.record.readers import read_log
from mjfriction.robot.body_tables import LinkInertia, Payload
from mjfriction.robot.files import read_robot
from mjfriction.robot.robot import Robot
from mjfriction.robot.schema import Spring
from mjfriction.robot.table import Edge, Spot, Wave
from tests.hidden.machine import Machine, write_case

ELBOW = 2


def gap_of_machine(folder: Path, machine: Machine) -> Gap:
    log, robot = write_case(folder, machine, seed=1, seconds=20.0)
    return measure_gap(read_log(log), read_robot(robot))


def test_beside_a_payload_friction_under_load_is_drawn_with_it(tmp_path: Path) -> None:
    gap = gap_of_machine(tmp_path, Machine())
    table = gap.robot.table.model_copy(
        update={"payload": Payload(mass=5.0, com=(0.0, 0.0, 0.1), parent="wrist_3_link")}
    )
    carrying = Robot(table, gap.robot.folder)
    known = gap.beside(carrying)
    stated, drawn = (Load().columns(one, Site(ELBOW))[ELBOW] for one in (gap, known))
    # What is stated of a robot that carries the payload is what is known of one on which it was found.
    direct = Load().columns(gap_of(carrying, gap), Site(ELBOW))[ELBOW]
    np.testing.assert_allclose(drawn, direct, rtol=1e-9)
    assert np.linalg.norm(drawn - stated) > 0.2 * np.linalg.norm(stated)
    np.testing.assert_array_equal(known.residual, gap.residual)


@pytest.mark.parametrize(("delay", "refused"), [(-0.02, True), (0.02, False)])
def test_beside_play_an_effort_that_seems_early_is_a_landing(delay: float, refused: bool, tmp_path: Path) -> None:
    shifted = Machine(
        hidden={
            ELBOW: lambda i: np.interp(i.time - delay, i.time, i.rigid + i.friction) - (i.rigid + i.friction),
        }
    )
    gap = gap_of_machine(tmp_path, shifted)
    play, late = Chosen(Backlash(), Site(ELBOW, around=0.001)), Chosen(JointDelay(), Site(ELBOW))
    model = build_model(gap, make_nuisance(gap), (play, late))
    assert [choice.key for choice in _of_landings(model)] == ([late.key] if refused else [])
    assert _of_landings(model.without(play)) == []


WAVE = Wave(wavenumber=8.0, cosine=1.5, sine=-2.0)


@pytest.mark.parametrize(
    "stated",
    [
        lambda _: {"cogging": (WAVE,), "friction_waves": (WAVE,), "spring": Spring(stiffness=20.0, preload=1.0)},
        lambda middle: {"friction_spots": (Spot(position=middle, width=0.2, coulomb=30.0),)},
        lambda middle: {"friction_edges": (Edge(position=middle, width=0.2, coulomb=60.0, side="below"),)},
    ],
    ids=["waves and spring", "spot", "edge"],
)
def test_a_zero_that_is_off_moves_what_is_stated_along_the_stroke(
    stated: Callable[[float], dict[str, object]], tmp_path: Path
) -> None:
    plain = gap_of_machine(tmp_path, Machine())
    middle = float(np.median(plain.motion.position[:, ELBOW]))
    varied = plain.robot.table.joint[ELBOW].model_copy(update=stated(middle))
    gap = gap_of(plain.robot.with_joint(varied), plain)
    drawn = EncoderOffset().columns(gap, Site(ELBOW))[ELBOW][:, 0]
    step = 1e-4
    moved = EncoderOffset().extend(gap.robot, Site(ELBOW), np.array([step]))
    difference = (gap_of(moved, gap).residual - gap.residual)[:, ELBOW] / -step
    away = gap.clear[:, ELBOW]
    np.testing.assert_allclose(drawn[away], difference[away], atol=0.01 * float(np.max(np.abs(difference))))
    without = EncoderOffset().columns(plain, Site(ELBOW))[ELBOW][:, 0]
    assert np.linalg.norm(without - difference) > 0.5 * np.linalg.norm(difference)


@pytest.mark.deep
@pytest.mark.parametrize("stated", [0.0, 1.0])
def test_a_link_that_but_turns_about_its_upright_joint_is_a_rotor_for_all_it_shows(
    stated: float, tmp_path: Path
) -> None:
    machine = Machine(noise=0.05, hidden={0: lambda i: (stated + 0.8) * i.a})
    log, path = write_case(tmp_path, machine, seed=21, off=0.05)
    robot = read_robot(path)
    if stated:
        own = LinkInertia(mass=3.7, com=(0.0, 0.0, 0.0), inertia=(stated, stated, stated, 0.0, 0.0, 0.0))
        robot = Robot(robot.table.model_copy(update={"link_inertia": {"shoulder_pan_joint": own}}), robot.folder)
    gap = measure_gap(read_log(log), robot)
    assert same_columns(gap, Chosen(RotorInertia(), Site(0)), Chosen(LinkScale(), Site(0)))
    assert not same_columns(gap, Chosen(RotorInertia(), Site(2)), Chosen(LinkScale(), Site(2)))
    (finding,) = diagnose_log(read_log(log), robot).findings
    assert (finding.cause, finding.joint) == ("drive.rotor_inertia", "shoulder_pan_joint")
    # The UR5's own link would have to weigh a hundred times what is stated.
    assert finding.alternatives == (("body.link_inertia",) if stated else ())
    assert (finding.confidence > 0.5) is (not stated)
