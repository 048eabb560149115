"""Elements from slow turns: the loops they draw, how many there are, the Leuven law's own coordinate."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from numpy.typing import NDArray

from mjfriction.errors import LogError
from mjfriction.identify.hysteresis import bristle_travel, elements_of
from mjfriction.laws.ambient import ambient
from mjfriction.laws.catalog import find_law

Floats = NDArray[np.float64]
TURNS = (3.0, 3.0, 1.5, 0.8, 3.0, 2.0, 1.0, 0.5, 3.0)


def turns(sizes: tuple[float, ...] = TURNS) -> Floats:
    corners = np.concatenate([[0.0], *([a, -a] for a in sizes), [0.0]])
    return np.concatenate([np.linspace(a, b, 200) for a, b in itertools.pairwise(corners.tolist())])


def force_of(law: str, values: dict[str, object], position: Floats) -> Floats:
    found = find_law(law)
    packed = found.pack(values)  # type: ignore[arg-type]
    return found.follow(np.diff(position, prepend=position[0]), ambient(position.size), 1.0, packed)[0]


SLIP = {"viscous": 0.0, "stiffness": [8.0, 4.0, 1.5], "level": [1.6, 4.0, 3.0]}


def test_elements_draw_the_loops_that_they_were_not_fitted_to() -> None:
    position = turns()
    found = elements_of(position, force_of("maxwell_slip", SLIP, position))
    other = turns((2.5, 0.9, 1.7, 0.3, 2.2))
    packed = {"viscous": 0.0, "stiffness": found.stiffness.tolist(), "level": found.level.tolist()}
    true, told = force_of("maxwell_slip", SLIP, other), force_of("maxwell_slip", packed, other)
    assert np.sqrt(np.mean(np.square(true - told))) < 0.02 * np.sqrt(np.mean(np.square(true)))
    # And one element alone does not: the memory of inner loops lies in the others.
    single = elements_of(position, force_of("maxwell_slip", SLIP, position), (1,))
    assert single.left > 20.0 * found.left


def test_one_element_is_one_element() -> None:
    # On its own ladder a single spring is met by the first count that has a rung there.
    position = turns()
    force = force_of("maxwell_slip", {"viscous": 0.0, "stiffness": [2.0], "level": [6.0]}, position)
    found = elements_of(position, force)
    assert found.travel.size == 1
    assert found.stiffness[0] == pytest.approx(2.0, rel=1e-9)
    assert found.left < 1e-9


def test_noise_does_not_make_elements() -> None:
    position = turns()
    clean = force_of("maxwell_slip", SLIP, position)
    noisy = clean + 0.5 * np.random.default_rng(0).standard_normal(clean.size)
    few, many = elements_of(position, noisy), elements_of(position, clean)
    assert few.stiffness.size < many.stiffness.size
    assert few.left == pytest.approx(0.5, rel=0.1)


def test_few_turns_make_no_wild_elements() -> None:
    # What `plan --protocol sawtooth` makes: with half of three cycles left out, many elements look alike.
    position = turns((3.0, 1.8, 0.9))
    force = force_of("maxwell_slip", SLIP, position) + 0.02 * np.random.default_rng(1).standard_normal(position.size)
    found = elements_of(position, force)
    assert max(found.heldout.values()) < np.ptp(force)
    assert found.left < 0.2


def test_a_zero_beside_the_force_is_told_apart() -> None:
    position = turns()
    assert elements_of(position, force_of("maxwell_slip", SLIP, position) + 2.5).zero == pytest.approx(2.5, abs=0.1)


def test_the_leuven_laws_elements_are_met_over_its_own_travel_not_over_position() -> None:
    position = turns()
    curve = {"coulomb": 6.0, "static": 6.0, "stribeck_velocity": 1e9, "stribeck_exponent": 1.0, "viscous": 0.0}
    law = {**curve, "bristle_damping": 0.0, "shape_exponent": 2.0, "stiffness": [6.0, 2.0], "level": [3.0, 6.0]}
    force = force_of("leuven", law, position)
    velocity = np.diff(position, prepend=position[0])
    travel = bristle_travel(position, velocity, force, np.full(position.size, 6.0), 2.0)
    over = elements_of(travel, force, (80,)).left
    beside = elements_of(position, force, (80,)).left
    assert over < 0.5 * beside
    assert over < 0.02 * np.sqrt(np.mean(np.square(force)))


@pytest.mark.parametrize("position", [np.linspace(0.0, 1.0, 500), turns((1.0,)), np.zeros(500)])
def test_too_few_turns_are_refused(position: Floats) -> None:
    with pytest.raises(LogError, match="half turns are too few"):
        elements_of(position, position)


def test_a_force_that_follows_no_turn_is_refused() -> None:
    position = turns()
    with pytest.raises(LogError, match="does not follow the turns"):
        elements_of(position, -position)
