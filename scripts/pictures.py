"""Pictures of the report's figures for the documentation, drawn by a headless browser (chromium on the path)."""

from __future__ import annotations

import shutil
import subprocess
import tempfile
from pathlib import Path

import plotly.graph_objects as go
from plotly.offline import get_plotlyjs

from mjfriction.report.figures import figure_html

SIZE = (900, 420)


def draw_figure(figure: go.Figure, target: Path) -> None:
    """Write a figure of the report as a picture on white."""
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
