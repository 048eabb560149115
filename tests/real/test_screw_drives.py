"""Three screw drives, run at steady speeds: which of them needs a Stribeck curve."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from mjfriction.identify.map_choice import choose_on_map
from mjfriction.laws.catalog import find_law
from scripts.real_runs.screw_drives import LAWS, PUBLISHED, map_of


@pytest.mark.parametrize(
    ("drive", "law"),
    [(1, "stribeck"), (2, "coulomb_viscous"), (3, "coulomb_viscous")],
)
def test_only_the_first_drive_needs_a_stribeck_curve(drive: int, law: str, data: Path) -> None:
    points = map_of(data / f"screw_drives/drive{drive}_steady.parquet")
    tried = choose_on_map(points, [find_law(name) for name in LAWS], "joint", 1.0)
    assert tried[0].law.name == law
    size = float(np.sqrt(np.mean(np.square(points.friction))))
    missed = {one.law.name: float(np.sqrt(np.mean(np.square(one.missed)))) / size for one in tried}
    plain, with_stribeck = (0.01 * error for error in PUBLISHED[drive])
    if drive == 1:
        assert missed["stribeck"] < with_stribeck
        assert missed["coulomb_viscous"] > 0.04
    else:
        assert missed["coulomb_viscous"] < plain
