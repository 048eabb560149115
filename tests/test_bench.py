"""The benchmark script runs; its figures are nobody's business here."""

from __future__ import annotations

import subprocess
import sys

import pytest


@pytest.mark.deep
def test_the_small_benchmark_runs() -> None:
    done = subprocess.run(
        [sys.executable, "-m", "scripts.bench", "--small"], check=False, capture_output=True, text=True, timeout=400
    )
    assert done.returncode == 0, done.stderr
    for word in ("Cost(law='`lugre`'", "mjfriction", "native dcmotor lugre", "ours / native", "Two threads"):
        assert word in done.stdout
