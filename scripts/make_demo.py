"""Regenerate the logs that ``mjfriction demo`` reads: a UR5 in closed loop, with Stribeck friction hidden in its elbow.

Run: python -m scripts.make_demo
"""

from __future__ import annotations

from pathlib import Path

import pyarrow.parquet

from tests.hidden.closed_loop import record_closed_loop

FOLDER = Path(__file__).resolve().parent.parent / "mjfriction/bundled/demo"
ELBOW = 2


def main() -> None:
    FOLDER.mkdir(parents=True, exist_ok=True)
    for name, seed in (("log", 7), ("other_motion", 8)):
        table = record_closed_loop(seed, fading=ELBOW, excess=3.5, over=0.12)
        pyarrow.parquet.write_table(table, FOLDER / f"{name}.parquet", compression="zstd")


if __name__ == "__main__":
    main()
