"""The command line that the benchmark requires of a tool: ``diagnose`` and ``predict``."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path

Verb = Callable[[Path, Path, Path], None]
"""(log, robot file, folder or file to write)"""


def run_verbs(description: str | None, diagnose: Verb, predict: Verb) -> None:
    """Run the verb that the command line asks for."""
    parser = argparse.ArgumentParser(description=description, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("verb", choices=["diagnose", "predict"])
    parser.add_argument("log", type=Path)
    parser.add_argument("--robot", type=Path, required=True)
    parser.add_argument("--out", type=Path, required=True)
    asked = parser.parse_args()
    {"diagnose": diagnose, "predict": predict}[asked.verb](asked.log, asked.robot, asked.out)
