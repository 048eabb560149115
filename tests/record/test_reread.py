"""Columns that are read as they should have been."""

from __future__ import annotations

import numpy as np

from mjfriction.record.fault import Mend
from mjfriction.record.log import Log
from mjfriction.record.reread import reread

COUNT = 6


def a_log() -> Log:
    columns = {name: k + np.arange(COUNT, dtype=float) for k, name in enumerate(("position.a", "position.b"))}
    unusable = {"position.a": np.arange(COUNT) == 4}
    return Log("log", np.arange(COUNT, dtype=float), np.zeros(COUNT, dtype=np.int64), ("a", "b"), columns, (), unusable)


def test_a_factor_and_an_exchange_hold_within_their_span_alone() -> None:
    log = a_log()
    mend = Mend((("position.a", -2.0), ("velocity.a", 5.0)), (("position.a", "position.b"),), (2.0, 5.0))
    read = reread(log, mend)
    one, other = log.columns["position.a"], log.columns["position.b"]
    inside = np.array([False, False, True, True, True, False])
    np.testing.assert_array_equal(read.columns["position.a"], np.where(inside, other, one))
    np.testing.assert_array_equal(read.columns["position.b"], np.where(inside, -2.0 * one, other))
    assert read.columns.keys() == log.columns.keys()
    assert np.flatnonzero(read.unusable["position.b"]).tolist() == [4]
    assert not np.any(read.unusable["position.a"])


def test_an_exchange_undoes_itself() -> None:
    mend = Mend(exchanged=(("position.a", "position.b"),))
    twice = reread(reread(a_log(), mend), mend)
    for name, values in a_log().columns.items():
        np.testing.assert_array_equal(twice.columns[name], values)
    assert np.flatnonzero(twice.unusable["position.a"]).tolist() == [4]
