"""Run the source documents' experiments and write docs/reproduced.md and its picture; some minutes.

Run: python -m scripts.reproduced_page
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

import matplotlib
import matplotlib.pyplot as plt

from mjfriction.reproduce.catalog import DOCUMENTS, reproduce
from mjfriction.reproduce.outcome import Picture, Reproduction, Table

matplotlib.use("Agg")
ROOT = Path(__file__).resolve().parent.parent
SHOWN = (("table", "figure 4B"), ("table", "figure 9"), ("hydraulic", "figure 6"), ("manipulator", "figure 2"))
HEAD = """# The documents' experiments, run

Written by `python -m scripts.reproduced_page`. `mjfriction reproduce all --out DIR` writes the same, with every figure,
as a page of its own. All machines are simulated; what is printed in the documents stands beside ours.

![loops, tracking errors, friction](images/reproduced.png)
"""


def shown(cell: float | str | None) -> str:
    return "" if cell is None else cell if isinstance(cell, str) else f"{cell:.4g}"


def table_lines(table: Table) -> list[str]:
    lines = [f"### {table.title}", "", f"| | {' | '.join(name.strip() for name in table.columns)} |"]
    lines.append(f"|---|{'---:|' * len(table.columns)}")
    lines += [f"| {row.name} | {' | '.join(shown(cell) for cell in row.cells)} |" for row in table.rows]
    return [*lines, "", *([table.note, ""] if table.note else [])]


def page(found: Sequence[Reproduction]) -> str:
    lines = [HEAD]
    for one in found:
        lines += [f"## {one.title}", "", f"After {one.source}.", ""]
        for claim in one.claims:
            lines.append(f"- **{'Holds here' if claim.holds else 'Not here'}**: {claim.sentence} ({claim.figures})")
        lines += ["", "How:", "", *(f"- {sentence}" for sentence in one.how)]
        lines += ["", "Where ours differs, and why:", "", *(f"- {sentence}" for sentence in one.differs), ""]
        for table in one.tables:
            lines += table_lines(table)
    return re.sub(r"\n{3,}", "\n\n", "\n".join(lines)).rstrip() + "\n"


def draw(pictures: Sequence[Picture], target: Path) -> None:
    figure, axes = plt.subplots(2, 2, figsize=(11, 7), layout="constrained")
    for axis, picture in zip(axes.ravel(), pictures, strict=True):
        for line in picture.lines:
            axis.plot(line.x, line.y, "o" if line.marks else "-", markersize=4, linewidth=1.1, label=line.name)
        axis.set(title=picture.title, xlabel=picture.across, ylabel=picture.up)
        axis.set_xscale("log" if picture.logarithmic else "linear")
        axis.grid(alpha=0.3)
        axis.legend(fontsize=8)
    figure.savefig(target, dpi=90)


if __name__ == "__main__":
    results = reproduce(DOCUMENTS, print, jobs=2)
    by_name = {one.name: one for one in results}
    chosen = [next(p for p in by_name[name].pictures if p.figure == which) for name, which in SHOWN]
    draw(chosen, ROOT / "docs/images/reproduced.png")
    (ROOT / "docs/reproduced.md").write_text(page(results), encoding="utf-8")
