"""Block-wise normal equations against plain least squares on the rows."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from mjfriction.identify.normal import Products
from mjfriction.identify.regression import Rows, System

JOINTS, ROWS, BLOCKS = 2, 600, 20


def problem(seed: int = 0) -> tuple[Rows, list[dict[int, np.ndarray]], list[np.ndarray]]:
    rng = np.random.default_rng(seed)
    rows = Rows(
        target=rng.normal(size=(ROWS, JOINTS)),
        weight=rng.uniform(0.5, 2.0, (ROWS, JOINTS)),
        block=np.repeat(np.arange(BLOCKS), ROWS // BLOCKS),
    )
    columns = [{0: rng.normal(size=(ROWS, 2))}, {0: rng.normal(size=(ROWS, 1)), 1: rng.normal(size=(ROWS, 1))}]
    return rows, columns, [np.zeros(2), np.zeros(1)]


def stacked(rows: Rows, columns: list[dict[int, np.ndarray]], kept: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    widths = [next(iter(block.values())).shape[1] for block in columns]
    left, right = [], []
    for joint in range(JOINTS):
        parts = [b.get(joint, np.zeros((ROWS, w))) for b, w in zip(columns, widths, strict=True)]
        weight = rows.weight[kept, joint]
        left.append(np.hstack(parts)[kept] * weight[:, None])
        right.append(rows.target[kept, joint] * weight)
    return np.vstack(left), np.concatenate(right)


def assert_same(products: Products, expected: Products) -> None:
    for own, other in zip(products.parts, expected.parts, strict=True):
        for name in ("felt", "gram", "moment", "power"):
            np.testing.assert_allclose(getattr(own, name), getattr(other, name), rtol=1e-12, atol=1e-12)
    for own_sum, other_sum in zip(products.of_blocks, expected.of_blocks, strict=True):
        np.testing.assert_allclose(own_sum, other_sum, rtol=1e-12, atol=1e-11)


def test_strengths_errors_and_held_out_errors_are_those_of_the_rows() -> None:
    rows, columns, precisions = problem()
    system = System(rows, columns, precisions)
    a, y = stacked(rows, columns, np.ones(ROWS, dtype=bool))
    expected = np.linalg.lstsq(a, y, rcond=None)[0]
    strengths = system.normal.fitted
    np.testing.assert_allclose(strengths, expected, rtol=1e-6)
    assert system.normal.error(strengths).sum() == pytest.approx(np.sum((y - a @ expected) ** 2), rel=1e-9)
    np.testing.assert_allclose(system.normal.strengths(np.ones(BLOCKS, dtype=bool)), strengths, rtol=1e-9)
    fold = np.arange(BLOCKS) % 4 == 1
    a, y = stacked(rows, columns, ~fold[rows.block])
    elsewhere = np.linalg.lstsq(a, y, rcond=None)[0]
    b, z = stacked(rows, columns, fold[rows.block])
    held = system.normal.heldout_errors([fold])
    assert held[:, fold].sum() == pytest.approx(np.sum((z - b @ elsewhere) ** 2), rel=1e-6)


def test_rows_that_count_otherwise_make_the_equations_that_they_would_have_made_at_once() -> None:
    rows, columns, precisions = problem()
    weight = rows.weight.copy()
    weight[:, 1] *= np.linspace(0.5, 2.0, ROWS)
    anew = System(dataclasses.replace(rows, weight=weight), columns, precisions)
    found = System(rows, columns, precisions).reweighted(weight, [1])
    assert_same(found.normal.products, anew.normal.products)
    strengths = found.normal.fitted
    np.testing.assert_allclose(found.residual(strengths), anew.residual(strengths), rtol=1e-9, atol=1e-12)
    candidate = {1: np.random.default_rng(9).normal(size=(ROWS, 1, 1))}
    np.testing.assert_allclose(found.screen(candidate)[1], anew.screen(candidate)[1], rtol=1e-9)


def test_screening_and_extending_agree_with_a_fit_of_everything() -> None:
    rows, columns, precisions = problem()
    candidate = {1: np.random.default_rng(9).normal(size=(ROWS, 2))}
    system = System(rows, columns, precisions)
    full = System(rows, [*columns, candidate], [*precisions, np.zeros(2)]).normal
    many = np.stack([candidate[1], 2.0 * candidate[1]], axis=1)
    (strengths, doubled), (gain, same) = system.screen({1: many})
    np.testing.assert_allclose(2.0 * doubled, strengths, rtol=1e-6)
    assert same == pytest.approx(gain, rel=1e-6)
    np.testing.assert_allclose(strengths, full.fitted[-2:], rtol=1e-6)
    before = system.normal.error(system.normal.fitted).sum()
    assert gain == pytest.approx(before - full.error(full.fitted).sum(), rel=1e-6)
    thinned, _ = system.screen({1: many[::3]}, every=3)
    np.testing.assert_allclose(thinned[0], strengths, atol=0.2)
    extended = system.extended(candidate, np.zeros(2))
    assert_same(extended.products, full.products)


def test_what_the_model_nearly_holds_is_screened_on_the_models_own_rows() -> None:
    # A payload's mass is nearly a sum of links that the model refits: on every third row its strength must come out as
    # in a fit of every third row, not of a difference between two sets of rows.
    rows, columns, precisions = problem()
    nearly = columns[0][0][:, [1]] + 1e-2 * np.random.default_rng(5).normal(size=(ROWS, 1))
    target = rows.target.copy()
    target[:, 0] += nearly[:, 0]
    rows = dataclasses.replace(rows, target=target)
    (strength,), (gain,) = System(rows, columns, precisions).screen({0: nearly[::3, None, :]}, every=3)
    thin = Rows(rows.target[::3], rows.weight[::3], rows.block[::3])
    thinned = [{joint: values[::3] for joint, values in block.items()} for block in columns]
    alone = System(thin, [*thinned, {0: nearly[::3]}], [*precisions, np.zeros(1)]).normal
    expected = alone.fitted[-1]
    np.testing.assert_allclose(strength, expected, rtol=1e-3)
    assert gain > 0.0


def test_means_over_rows_keep_what_is_slow_and_forget_what_is_quick() -> None:
    rng, count = np.random.default_rng(2), 1008
    time = np.arange(count) * 0.01
    slow, quick = np.sin(0.7 * time), np.sin(2.0 * np.pi * time / 0.21)  # three periods in 63 rows
    target = (0.5 * slow + 3.0 * quick + 0.01 * rng.normal(size=count))[:, None]
    rows = Rows(target, np.ones_like(target), np.arange(count) // 126)
    system = System(rows, [{0: (slow + quick)[:, None]}], [np.zeros(1)])
    assert system.normal.fitted[0] > 1.5
    assert system.averaged(63).fitted[0] == pytest.approx(0.5, abs=0.01)
    # A mean of one row is that row, and equal rows are worth as much as their mean is by its weight.
    assert_same(system.averaged(1).products, system.normal.products)
    alike = Rows(np.full((12, 1), 2.0), np.ones((12, 1)), np.repeat([0, 1], 6))
    constant = System(alike, [{0: np.ones((12, 1))}], [np.zeros(1)])
    assert_same(constant.averaged(4).products, constant.normal.products)


def test_a_column_the_model_holds_already_gains_nothing() -> None:
    rows, columns, precisions = problem()
    strengths, gain = System(rows, columns, precisions).screen({0: 3.0 * columns[0][0][:, None, [1]]})
    assert strengths.tolist() == [[0.0]]
    assert gain.tolist() == [0.0]


def test_a_prior_pulls_towards_zero() -> None:
    rows, columns, _ = problem()
    free = System(rows, columns, [np.zeros(2), np.zeros(1)]).normal.fitted
    held = System(rows, columns, [np.zeros(2), np.array([1e9])]).normal.fitted
    assert abs(held[2]) < 1e-5 * abs(free[2])


def covered(coloured: float, draws: int = 400) -> float:
    """Share of 95 % intervals of a slope of 1 that hold it, under AR(1) noise."""
    rng = np.random.default_rng(2)
    block = np.repeat(np.arange(40), 25)
    course = np.sin(np.arange(1000) * 0.02)[:, None]
    hits = 0
    for _ in range(draws):
        white = rng.normal(size=1000)
        noise = np.empty(1000)
        noise[0] = white[0]
        for i in range(1, 1000):
            noise[i] = coloured * noise[i - 1] + white[i]
        rows = Rows(course + noise[:, None], np.ones((1000, 1)), block)
        normal = System(rows, [{0: course}], [np.zeros(1)]).normal
        strengths = normal.fitted
        deviation = np.sqrt(normal.covariance(np.arange(40))[0, 0])
        hits += abs(strengths[0] - 1.0) < 2.02 * deviation
    return hits / draws


def test_intervals_cover_under_white_and_under_coloured_noise() -> None:
    assert 0.91 < covered(0.0) < 0.98
    assert 0.88 < covered(0.8) < 0.98


def test_what_repeats_alike_is_no_noise() -> None:
    rng = np.random.default_rng(3)
    block = np.repeat(np.arange(40), 25)
    repetition = np.arange(40) // 5
    course = np.tile(np.sin(np.arange(125) * 0.2), 8)[:, None]
    misfit = np.tile(np.cos(np.arange(125) * 0.1), 8)[:, None]
    rows = Rows(course + misfit + 0.1 * rng.normal(size=(1000, 1)), np.ones((1000, 1)), block)
    normal = System(rows, [{0: course}], [np.zeros(1)]).normal
    repeated = np.sqrt(normal.covariance(repetition)[0, 0])
    assert repeated == pytest.approx(0.1 / np.sqrt(np.sum(course**2)), rel=0.6)
    assert np.sqrt(normal.covariance(np.arange(40))[0, 0]) > 2.0 * repeated
