"""Regenerate what the documentation shows: the demo's output in the README and its picture.

The picture is drawn by a headless browser (chromium on the path).  Run: python -m scripts.make_docs
"""

from __future__ import annotations

import contextlib
import io
import re
import shutil
import subprocess
import tempfile
from pathlib import Path

from plotly.offline import get_plotlyjs

from mjfriction.cli.demo import demo
from mjfriction.diagnose.diagnosis import diagnose_log
from mjfriction.record.readers import read_log
from mjfriction.report.figures import figure_html, residual_against_covariate
from mjfriction.robot.files import read_robot

ROOT = Path(__file__).resolve().parent.parent
DEMO = ROOT / "mjfriction/bundled/demo/log.parquet"
SIZE = (900, 420)


def demo_text() -> str:
    with (
        tempfile.TemporaryDirectory() as folder,
        contextlib.chdir(folder),
        contextlib.redirect_stdout(io.StringIO()) as out,
    ):
        demo(Path("demo_out"))
    return out.getvalue().strip()


def write_readme(text: str) -> None:
    readme = ROOT / "README.md"
    block = f"<!-- demo begin -->\n```text\n{text}\n```\n<!-- demo end -->"
    changed = re.sub(
        r"<!-- demo begin -->.*?<!-- demo end -->", lambda _: block, readme.read_text("utf-8"), flags=re.DOTALL
    )
    readme.write_text(changed, encoding="utf-8")


def draw_residual(target: Path) -> None:
    diagnosis = diagnose_log(read_log(DEMO), read_robot("ur5"))
    figure = residual_against_covariate(diagnosis, diagnosis.findings[0])
    figure.update_layout(paper_bgcolor="white", width=SIZE[0] - 20, height=SIZE[1] - 20, font_color="#333333")
    page = (
        f"<body style='margin:10px;background:white'><script>{get_plotlyjs()}</script>{figure_html(figure, 'f')}</body>"
    )
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "page.html").write_text(page, encoding="utf-8")
        browser = shutil.which("chromium") or "chromium"
        subprocess.run(
            [
                browser, "--headless", "--no-sandbox", "--disable-gpu", "--disable-background-networking",
                f"--user-data-dir={folder}/profile", f"--window-size={SIZE[0]},{SIZE[1]}", "--virtual-time-budget=5000",
                f"--screenshot={target}", f"file://{folder}/page.html",
            ],
            check=True, capture_output=True,
        )  # fmt: skip


if __name__ == "__main__":
    write_readme(demo_text())
    draw_residual(ROOT / "docs/images/demo_residual.png")
