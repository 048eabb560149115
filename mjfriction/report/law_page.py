"""A law's description and portrait, in the terminal and as a page."""

from __future__ import annotations

import textwrap
from pathlib import Path

import plotly.graph_objects as go
from plotly.subplots import make_subplots

from mjfriction.laws.law import Law
from mjfriction.laws.portrait import Curve, Portrait, portrait
from mjfriction.report.canvas import line_plot

PANELS = (
    ("steady", "Steady friction", "velocity, rad/s"),
    ("presliding", "Before slip: slow, with an inner loop", "travel, rad"),
    ("lag", "Lag: sliding faster and slower", "velocity, rad/s"),
    ("breakaway", "Breakaway from rest at three speeds", "travel, rad"),
)
# The position of each panel's legend, in the corner that its curves leave free.
LEGENDS = {
    "steady": {"x": 0.445, "y": 0.63, "yanchor": "bottom"},
    "presliding": {"x": 0.995, "y": 0.63, "yanchor": "bottom"},
    "lag": {"x": 0.445, "y": 0.37, "yanchor": "top"},
    "breakaway": {"x": 0.995, "y": 0.01, "yanchor": "bottom"},
}
COLOURS = ("#1b80c4", "#d1495b", "#b7a26a")


def describe(law: Law, width: int = 80) -> str:
    """Return a law as lines of text: its summary, formula and parameters, its steady curve and presliding loop."""

    def wrapped(label: str, text: str) -> str:
        return textwrap.fill(text, width, initial_indent=f"{label:<10}", subsequent_indent=" " * 10)

    lines = [
        f"{law.name}: {law.summary}",
        "",
        wrapped("formula", law.formula),
        wrapped("captures", law.captures),
        wrapped("misses", law.misses),
        wrapped("source", law.source),
        "",
        "parameters (of a revolute joint; on a sliding one N·m is N and rad is m)",
    ]
    for parameter in (*law.parameters, *law.elements):
        each = ", one for every element" if parameter in law.elements else ""
        default = f", default {parameter.default:g}" if parameter.default is not None else ""
        text = f"{parameter.meaning}; {parameter.unit_for(sliding=False)}, {parameter.allowed}{default}{each}"
        lines.append(textwrap.fill(text, width, initial_indent=f"  {parameter.name:<24}", subsequent_indent=" " * 26))
    drawn = portrait(law)
    inner = width - 12
    lines += ["", _text(drawn.steady[0], inner, "steady friction", "velocity, rad/s")]
    if law.has_state:
        lines += ["", _text(drawn.presliding[0], inner, "slow travel to and fro, with an inner loop", "travel, rad")]
    return "\n".join(lines)


def _text(curve: Curve, width: int, title: str, across: str) -> str:
    return line_plot(curve.x, curve.torque, width=width, height=10, title=title, across=across, up="N·m")


def law_figure(law: Law, drawn: Portrait) -> go.Figure:
    """Return the four panels of a law's portrait; only the first for a law without states, which needs no others."""
    if not law.has_state:
        figure = go.Figure()
        for curve, colour in zip(drawn.steady, COLOURS, strict=False):
            figure.add_scatter(x=curve.x, y=curve.torque, name=curve.name, line_color=colour)
        figure.update_xaxes(title_text=PANELS[0][2])
        figure.update_yaxes(title_text="torque, N·m")
        return figure.update_layout(title=_title(law), template="plotly_white", height=480)
    figure = make_subplots(rows=2, cols=2, subplot_titles=[title for _, title, _ in PANELS])
    for k, (name, _, across) in enumerate(PANELS):
        at = {"row": k // 2 + 1, "col": k % 2 + 1}
        legend = f"legend{k + 1}" if k else "legend"
        curves: tuple[Curve, ...] = getattr(drawn, name)
        for curve, colour in zip(curves, COLOURS, strict=False):
            own = {"name": curve.name, "showlegend": len(curves) > 1, "legend": legend}
            figure.add_scatter(x=curve.x, y=curve.torque, line_color=colour, **own, **at)
        figure.update_xaxes(title_text=across, **at)
        figure.update_yaxes(title_text="torque, N·m", **at)
        figure.update_layout({legend: LEGENDS[name] | {"xanchor": "right"}})
    return figure.update_layout(title=_title(law), template="plotly_white", height=760)


def _title(law: Law) -> str:
    return f"{law.name}: {law.summary}"


def write_law_page(law: Law, path: Path) -> None:
    """Write a law's portrait as a self-contained page that needs no network."""
    beside = path.with_name(f".{path.name}.part")
    beside.write_text(law_figure(law, portrait(law)).to_html(include_plotlyjs=True, full_html=True), encoding="utf-8")
    beside.replace(path)
