"""Regenerate what the documentation shows: the demo's output in the README and its picture.

Run: python -m scripts.make_docs
"""

from __future__ import annotations

import contextlib
import io
import tempfile
from pathlib import Path

from mjfriction.cli.demo import demo
from mjfriction.diagnose.diagnosis import diagnose_log
from mjfriction.record.readers import read_log
from mjfriction.report.finding_figure import finding_figure
from mjfriction.robot.files import read_robot
from scripts.marked import write_marked
from scripts.pictures import draw_figure

ROOT = Path(__file__).resolve().parent.parent
DEMO = ROOT / "mjfriction/bundled/demo/log.parquet"


def demo_text() -> str:
    with (
        tempfile.TemporaryDirectory() as folder,
        contextlib.chdir(folder),
        contextlib.redirect_stdout(io.StringIO()) as out,
    ):
        demo(Path("demo_out"))
    return out.getvalue().strip()


def write_readme(text: str) -> None:
    write_marked(ROOT / "README.md", "demo", f"```text\n{text}\n```")


def draw_residual(target: Path) -> None:
    diagnosis = diagnose_log(read_log(DEMO), read_robot("ur5"))
    draw_figure(finding_figure(diagnosis, diagnosis.findings[0]), target)


if __name__ == "__main__":
    write_readme(demo_text())
    draw_residual(ROOT / "docs/images/demo_residual.png")
