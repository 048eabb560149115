"""What is in a recording, by Rerun's own command."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path


def entities(path: Path) -> set[str]:
    """Return the paths of everything that a recording holds."""
    words = [sys.executable, "-m", "rerun", "rrd", "stats", str(path)]
    told = subprocess.run(words, capture_output=True, text=True, check=True).stdout
    return {line.rsplit(":", 1)[0] for line in told.splitlines() if line.startswith("/")}
