"""What does more at a joint, and is too little of its friction to be told, is not told under another cause's name."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from mjfriction.diagnose.causes.cause import Site
from mjfriction.diagnose.causes.presliding import Presliding
from mjfriction.diagnose.causes.viscous_nonlinear import ViscousNonlinear
from mjfriction.diagnose.fit.model import Chosen
from mjfriction.diagnose.search import compete
from mjfriction.diagnose.search.field import Chances
from mjfriction.diagnose.search.short_list import Tried

CHANCES = Chances(100, {})
MODEL: Any = SimpleNamespace(gap=None, nuisance=None, chosen=(), with_also=lambda _: MODEL)


def trial(cause: Any, merit: float, *, large: bool = True, beyond: bool = True, joint: int = 0) -> Any:
    return SimpleNamespace(
        chosen=Chosen(cause, Site(joint)),
        merit=merit,
        passes=lambda _: large and beyond,
        beyond_chance=lambda _: beyond,
    )


@pytest.fixture
def beside(monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    """What a cause does once the better one is in the model."""
    out: dict[str, Any] = {"again": None}
    monkeypatch.setattr(compete, "try_out", lambda *_: out["again"])
    return out


def test_what_is_nothing_beside_it_is_not_believed(beside: dict[str, Any]) -> None:
    bristle, curve = trial(Presliding(), 44.0), trial(ViscousNonlinear(), 158.0, large=False)
    assert compete._stands_for_less(MODEL, bristle, [curve, bristle], CHANCES)
    beside["again"] = trial(Presliding(), 5.0, beyond=False)
    assert compete._stands_for_less(MODEL, bristle, [curve, bristle], CHANCES)


def test_what_holds_beside_it_is(beside: dict[str, Any]) -> None:
    beside["again"] = trial(Presliding(), 40.0)
    bristle, curve = trial(Presliding(), 44.0), trial(ViscousNonlinear(), 158.0, large=False)
    assert not compete._stands_for_less(MODEL, bristle, [curve, bristle], CHANCES)


@pytest.mark.parametrize(
    "other",
    [
        trial(ViscousNonlinear(), 30.0, large=False),  # does less
        trial(ViscousNonlinear(), 158.0),  # may be told itself
        trial(ViscousNonlinear(), 158.0, large=False, beyond=False),  # may be chance
        trial(ViscousNonlinear(), 158.0, large=False, joint=1),  # elsewhere
    ],
)
def test_no_other_counts(other: Any, beside: dict[str, Any]) -> None:
    bristle = trial(Presliding(), 44.0)
    assert not compete._stands_for_less(MODEL, bristle, [other, bristle], CHANCES)


def test_the_search_asks_it_of_all_that_pass_and_of_earlier_short_lists_too(
    beside: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    bristle, curve = trial(Presliding(), 44.0), trial(ViscousNonlinear(), 158.0, large=False)
    lists = [[curve], [bristle]]  # one short list after the other
    monkeypatch.setattr(compete, "SHORT_LIST", 1)
    monkeypatch.setattr(compete, "ranked", lambda *_: [0, 1])
    monkeypatch.setattr(compete, "all_tried", lambda _, which, __: [one for place in which for one in lists[place]])
    assert compete._passing(MODEL, (), CHANCES, Tried({}, {})) == []
    beside["again"] = trial(Presliding(), 40.0)
    assert compete._passing(MODEL, (), CHANCES, Tried({}, {})) == [bristle]
