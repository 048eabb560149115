"""What is kept of columns that were made, and what makes room."""

from __future__ import annotations

import numpy as np
import pytest

from mjfriction.identify import kept
from mjfriction.identify.kept import Kept
from mjfriction.identify.regression import Columns


def never() -> Columns:
    raise AssertionError("made again")


def test_what_was_made_is_recalled() -> None:
    own, made = Kept(), {0: np.ones((4, 1))}
    assert own.recall("a", lambda: made) is made
    assert own.recall("a", never) is made


def test_what_was_not_asked_for_the_longest_makes_room(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(kept, "MOST_NUMBERS", 10)
    own = Kept()
    for name in ("first", "second"):
        own.recall(name, lambda: {0: np.ones((5, 1))})
    own.recall("first", never)
    own.recall("third", lambda: {0: np.ones((5, 1))})
    own.recall("first", never)
    with pytest.raises(AssertionError, match="made again"):
        own.recall("second", never)


def test_what_a_joint_feels_is_left_behind_with_it() -> None:
    own = Kept()
    own.recall("one", lambda: {0: np.ones((5, 1))})
    own.recall("both", lambda: {0: np.ones((5, 1)), 1: np.ones((5, 1))})
    apart = own.apart_from([1])
    apart.recall("one", never)
    with pytest.raises(AssertionError, match="made again"):
        apart.recall("both", never)
