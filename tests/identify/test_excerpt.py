"""A part of a long log stands for the whole: the same rows, of every block its share."""

from __future__ import annotations

import numpy as np
import pytest

from mjfriction.identify import excerpt as by
from mjfriction.identify.excerpt import excerpt
from mjfriction.identify.gap import Gap
from mjfriction.identify.measure import measure_gap, thinned
from mjfriction.record.readers import read_log
from mjfriction.robot.files import read_robot
from tests.hidden.machine import Machine, write_case

SECONDS, PART = 60.0, 12.0


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Gap:
    log, robot = write_case(tmp_path_factory.mktemp("log"), Machine(), seed=4, seconds=SECONDS, rate=250.0)
    return thinned(measure_gap(read_log(log), read_robot(robot)))


@pytest.fixture
def part(whole: Gap, monkeypatch: pytest.MonkeyPatch) -> Gap:
    monkeypatch.setattr(by, "ENOUGH", PART)
    return excerpt(whole)


def test_every_row_of_the_part_is_a_row_of_the_whole(whole: Gap, part: Gap) -> None:
    same = np.searchsorted(whole.chain.time, part.chain.time - 1e-6)
    np.testing.assert_allclose(whole.chain.time[same], part.chain.time, atol=1e-9)
    np.testing.assert_allclose(part.measured, whole.measured[same], atol=1e-9)
    # Which way a joint moved before a cut is not known: just after, friction's direction is no more than likely.
    clear = part.clear & whole.clear[same]
    off = np.abs(np.where(clear, part.residual - whole.residual[same], 0.0))
    assert np.mean(off[clear] < 1e-9) > 0.95
    assert np.all(off < 0.02 * whole.noise_floor)
    assert np.mean(clear) > 0.95 * np.mean(whole.clear)


def test_blocks_stay_what_they_are_and_give_the_same_share(whole: Gap, part: Gap) -> None:
    same = np.searchsorted(whole.chain.time, part.chain.time - 1e-6)
    assert np.array_equal(part.blocks.row, whole.blocks.row[same])
    assert np.array_equal(part.blocks.group, whole.blocks.group)
    share = PART / (whole.chain.time.size * whole.chain.step)
    assert np.array_equal(np.bincount(part.blocks.row), np.ceil(share * np.bincount(whole.blocks.row)))


def test_stretches_begin_anywhere_in_their_blocks(whole: Gap, part: Gap) -> None:
    """Where a motion repeats with the blocks, a part that always began at the same place would see only that."""
    begins = [np.min(part.chain.time[part.blocks.row == i]) for i in range(part.blocks.count)]
    blocks = [np.min(whole.chain.time[whole.blocks.row == i]) for i in range(whole.blocks.count)]
    into = (np.array(begins) - blocks) / (SECONDS / whole.blocks.count)
    free = 1.0 - PART / SECONDS
    assert np.ptp(into) > 0.8 * free
    assert np.mean(into) == pytest.approx(0.5 * free, abs=0.1)


def test_a_log_that_is_short_enough_stays_as_it_is(whole: Gap) -> None:
    assert excerpt(whole) is whole
