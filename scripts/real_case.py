"""The README's case of a real machine: the linear axis EMPS, diagnosed from one run and validated on the other.

MJFRICTION_DATA=folder-of-the-measured-logs python -m scripts.real_case
"""

from __future__ import annotations

import io
import os
from pathlib import Path

from rich.console import Console

import mjfriction as mjf
from mjfriction.report.result import make_report
from mjfriction.report.text import WIDTH, print_report
from scripts.marked import write_marked
from scripts.pictures import draw_figure

ROOT = Path(__file__).resolve().parent.parent
PICTURE = ROOT / "docs/images/emps_residual.png"


def main() -> None:
    folder = Path(os.environ["MJFRICTION_DATA"]) / "emps"
    stated = mjf.read_robot(folder / "robot.toml")
    diagnosis = mjf.diagnose_log(mjf.read_log(folder / "estimation.parquet"), stated)
    out = io.StringIO()
    print_report(make_report(diagnosis), Console(file=out, width=WIDTH, highlight=False))
    robots = [("stated", stated), ("extended", diagnosis.robot)]
    (axis,) = mjf.compare_robots(mjf.read_log(folder / "pulses.parquet"), robots).joints
    errors = " and ".join(f"{one.effort:.3g} N {name}" for one, (name, _) in zip(axis.errors, robots, strict=True))
    draw_figure(mjf.finding_figure(diagnosis, diagnosis.findings[0]), PICTURE)
    text = out.getvalue().strip()
    proof = f"The second run, with force pulses and fitted to nothing, is predicted with an RMS error of\n{errors}."
    write_marked(ROOT / "README.md", "real", f"```text\n{text}\n```\n\n{proof}")


if __name__ == "__main__":
    main()
