"""results.json and report.html of the source documents' experiments."""

from __future__ import annotations

import itertools
import json
from collections.abc import Sequence
from pathlib import Path

import plotly.graph_objects as go
from markupsafe import Markup

from mjfriction.report.figures import MEASURED, MODELS, figure_html, styled
from mjfriction.report.html import rendered
from mjfriction.reproduce.outcome import Picture, Reproduction

DIGITS = 4
MOST_POINTS = 1500  # of a drawn line
DRAWN_AS_MEASURED = ("measured", "passes", "true", "reference")


def reproduced_table(found: Sequence[Reproduction]) -> list[dict[str, object]]:
    """Return the outcomes as plain data, with numbers to four digits."""
    return [
        {
            "document": one.name,
            "source": one.source,
            "tables": [
                {
                    "title": table.title,
                    "columns": [name.strip() for name in table.columns],
                    "rows": [{"name": row.name, "cells": [_number(cell) for cell in row.cells]} for row in table.rows],
                }
                for table in one.tables
            ],
            "claims": [{"claim": c.sentence, "holds": c.holds, "figures": c.figures} for c in one.claims],
            "differs": list(one.differs),
        }
        for one in found
    ]


def write_reproduced(found: Sequence[Reproduction], folder: Path) -> None:
    """Write results.json and report.html."""
    table = json.dumps(reproduced_table(found), indent=2, ensure_ascii=False) + "\n"
    (folder / "results.json").write_text(table, encoding="utf-8")
    pictures = {
        one.name: [
            (picture, Markup(figure_html(_drawn(picture), f"{one.name}-{k}"))) for k, picture in enumerate(one.pictures)
        ]
        for one in found
    }
    page = rendered("reproduced.html.j2", found=found, pictures=pictures, shown=_shown)
    (folder / "report.html").write_text(page, encoding="utf-8")


def _number(cell: float | str | None) -> float | str | None:
    return float(f"{cell:.{DIGITS}g}") if isinstance(cell, float) else cell


def _shown(cell: float | str | None) -> str:
    return "" if cell is None else cell if isinstance(cell, str) else f"{cell:.{DIGITS}g}"


def _drawn(picture: Picture) -> go.Figure:
    figure = go.Figure()
    colours = itertools.cycle(MODELS)
    for line in picture.lines:
        colour = MEASURED if line.name in DRAWN_AS_MEASURED else next(colours)
        look = (
            {"mode": "markers", "marker": {"color": colour, "size": 6}}
            if line.marks
            else {"mode": "lines", "line": {"color": colour, "width": 1.6}}
        )
        kept = slice(None, None, max(1, -(-line.x.size // MOST_POINTS)))
        # Without WebGL: a browser allows a page only about sixteen WebGL contexts.
        figure.add_scatter(x=line.x[kept], y=line.y[kept], name=line.name, **look)
    figure.update_xaxes(title_text=picture.across, type="log" if picture.logarithmic else "linear")
    figure.update_yaxes(title_text=picture.up)
    return styled(figure, 380)
