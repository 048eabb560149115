"""What seeds draw: the same always, everything asked for, nothing that a machine cannot have."""

from __future__ import annotations

from collections import Counter

import numpy as np

from mjfriction.benchmark.drawing import ARMS, ROBOTS, draw_case
from mjfriction.benchmark.effects.catalog import EFFECTS
from mjfriction.benchmark.effects.effect import Place
from mjfriction.benchmark.effects.friction import position
from mjfriction.benchmark.effects.outside import OUTSIDE
from mjfriction.robot.files import read_robot

DRAWN = [draw_case(seed) for seed in range(1500)]


def test_a_seed_is_a_case() -> None:
    assert [draw_case(seed) for seed in range(50)] == DRAWN[:50]


def test_every_machine_every_effect_and_every_number_of_them_is_drawn() -> None:
    assert {drawn.setting.robot for drawn in DRAWN} == set(ROBOTS)
    assert {effect for drawn in DRAWN for effect in drawn.effects} == {*EFFECTS, *OUTSIDE}
    assert set(Counter(len(drawn.effects) for drawn in DRAWN)) == {0, 1, 2, 3}
    for key in ("quantity", "motion", "velocity", "off", "rate", "noise"):
        assert len({getattr(drawn.setting, key) for drawn in DRAWN}) >= 2


def test_friction_along_the_stroke_is_drawn_as_waves_spots_and_edges_on_either_side() -> None:
    time = np.linspace(0.0, 60.0, 600)
    place = Place(read_robot("ur5"), "elbow_joint", 0.0, 2.0, 0.5, time, np.sin(time))
    drawn = [position(np.random.default_rng(seed), place) for seed in range(60)]
    joints = [effect.change(place.robot, 0.5).joint("elbow_joint") for effect in drawn]
    forms = Counter(
        (bool(own.friction_waves), bool(own.friction_spots), *(edge.side for edge in own.friction_edges))
        for own in joints
    )
    assert set(forms) == {(True, False), (False, True), (False, False, "above"), (False, False, "below")}


def test_no_machine_gets_what_it_cannot_have() -> None:
    for drawn in DRAWN:
        names = {effect.__name__ for effect in drawn.effects}
        assert "pressure" not in names or drawn.setting.robot == "hydraulic_cylinder"
        assert "coupling" not in names or drawn.setting.robot in ARMS
        assert drawn.setting.motion == "excitation" or drawn.setting.robot in ARMS
        assert len(names) == len(drawn.effects)
