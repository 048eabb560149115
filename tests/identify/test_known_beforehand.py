"""What is known beforehand of some strengths: how many of them rows show, and how far wrong it makes the others."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from mjfriction.identify.normal import Normal, Part, Products

KNOWN = slice(0, 3)
USUAL = np.array([0.5, 0.2, 1.0])  # deviations of the first strengths; nothing is known of the others
BLOCKS, ROWS, DRAWN = 20, 15, 1500


@dataclass(frozen=True)
class Rows:
    """Regressors of blocks (blocks, rows, p), the first three not unlike the others."""

    regressors: np.ndarray

    def normal(self, strengths: np.ndarray, noise: np.ndarray) -> Normal:
        target = self.regressors @ strengths + noise
        gram = np.einsum("bri,brj->bij", self.regressors, self.regressors)
        moment = np.einsum("bri,br->bi", self.regressors, target)
        part = Part(np.arange(strengths.size), gram, moment, np.sum(np.square(target), axis=1))
        return Normal(Products((part,), strengths.size), np.concatenate([USUAL**-2.0, [0.0, 0.0]]))


@pytest.fixture(scope="module")
def rows() -> Rows:
    rng = np.random.default_rng(5)
    own = rng.normal(size=(BLOCKS, ROWS, 5))
    own[..., :3] = 0.02 * own[..., :3] + 0.2 * own[..., 3:4]
    return Rows(own)


def test_fits_are_as_far_off_as_noise_and_what_was_believed_make_them(rows: Rows) -> None:
    rng = np.random.default_rng(6)
    errors, said, by_noise = [], [], []
    for _ in range(DRAWN):
        true = np.concatenate([USUAL * rng.normal(size=3), [2.0, -1.0]])
        normal = rows.normal(true, rng.normal(size=(BLOCKS, ROWS)))
        errors.append(normal.fitted - true)
        noise = normal.covariance(np.arange(BLOCKS))
        by_noise.append(np.diag(noise))
        said.append(np.diag(noise + normal.leaning(KNOWN)))
    found = np.mean(np.square(errors), axis=0)
    assert np.mean(said, axis=0) == pytest.approx(found, rel=0.12)
    # What noise alone says of the fourth, for which the first three could stand in, is far from that.
    assert np.mean(by_noise, axis=0)[3] < 0.5 * found[3]


def test_as_many_are_shown_as_the_rows_say_more_of_than_is_known(rows: Rows) -> None:
    true, none = np.zeros(5), np.zeros((BLOCKS, ROWS))
    usual = rows.normal(true, none)
    assert 0.0 < usual.shown(KNOWN) < 3.0
    assert usual.tighter(KNOWN, 1e9).shown(KNOWN) == pytest.approx(0.0, abs=1e-6)
    assert usual.tighter(KNOWN, 1e-6).shown(KNOWN) == pytest.approx(3.0, abs=1e-3)
    assert Rows(100.0 * rows.regressors).normal(true, none).shown(KNOWN) > 2.9
