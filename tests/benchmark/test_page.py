"""The benchmark's page counts a cause as its scorer does."""

from __future__ import annotations

import pytest

from mjfriction.benchmark.score import Finding, Named, Outcome
from scripts.hidden_effects_page import told_as


@pytest.mark.parametrize(
    ("hidden", "how"),
    [
        (("drive.offset", "axis"), "found"),
        (("body.gravity_direction", None), "alternative"),  # what the whole arm feels has no joint to be named at
        (("body.spring", "axis"), "alternative"),
        (("body.spring", "other"), "missed"),
        (("body.payload", None), "missed"),
    ],
)
def test_a_cause_is_found_or_an_alternative_or_missed(hidden: Named, how: str) -> None:
    found = (Finding("drive.offset", "axis", 0.5, ("body.gravity_direction", "body.spring")),)
    assert told_as(Outcome((hidden,), found, "ambiguous", 1.0, 1.0), hidden) == how
