from __future__ import annotations

import os
from pathlib import Path

import pytest
from hypothesis import settings

# The first draw may compile a kernel; and a test run is the same every time.
settings.register_profile("project", deadline=None, derandomize=True)
settings.load_profile("project")


@pytest.fixture(scope="session")
def data() -> Path:
    """The folder of real measured logs; tests that use it skip where it is absent."""
    place = os.environ.get("MJFRICTION_DATA")
    if not place or not Path(place).is_dir():
        pytest.skip("real measured logs are absent: MJFRICTION_DATA does not name their folder")
    return Path(place)
