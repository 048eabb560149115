from __future__ import annotations

import os
from pathlib import Path

import pytest
from hypothesis import settings

PACKAGE = Path(__file__).parents[1] / "mjfriction"


def forget_stale_kernels() -> None:
    """Remove compiled kernels older than the newest source.

    Numba renews a kernel when its own file changes, not when a kernel that it calls, in another file, does.
    """
    sources = [*(PACKAGE / "laws").glob("*.py"), *(PACKAGE / "sim").glob("*.py"), *(PACKAGE / "control").glob("*.py")]
    newest = max(path.stat().st_mtime for path in sources)
    for compiled in PACKAGE.rglob("__pycache__/*.nb[ic]"):
        if compiled.stat().st_mtime < newest:
            compiled.unlink(missing_ok=True)


forget_stale_kernels()

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
