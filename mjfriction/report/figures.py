"""The pictures of the report page."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence

import numpy as np
import plotly.graph_objects as go
from numpy.typing import NDArray
from plotly.subplots import make_subplots

from mjfriction.record.log import Floats
from mjfriction.report.compared import Compared

# Colours that readers with colour blindness can distinguish, on a light and on a dark background.
BEFORE, AFTER, MEASURED, NOISE = "#d1495b", "#1b80c4", "#8a8d91", "#b7a26a"
MODELS = (BEFORE, AFTER, "#2a9d6f", "#8f5bb5", "#c98a1b")
INK = "#7d8590"
MOST_POINTS = 3000
COUNTED, ROOM = 0.995, 1.4  # quantile of the errors on clear rows, and the end of the error's axis as a multiple of it


def error_bars(compared: Compared, after: str) -> go.Figure:
    """Return bars of every joint's held-out RMS error, before and after, beside the sensor's noise."""
    joints = compared.joints
    errors = {
        "as stated": [error.rms_heldout_before for error in joints],
        after: [error.rms_heldout_after for error in joints],
    }
    unit = " and ".join(sorted({error.unit for error in joints}))
    return bars([error.joint for error in joints], errors, [error.noise_floor for error in joints], unit)


def time_course(compared: Compared, joint_name: str, after: str) -> go.Figure:
    """Return a joint's measured effort along the log, with predictions and errors of the stated and better robot."""
    gap = compared.gap
    joint = gap.robot.joints.index(joint_name)
    unit = float(gap.per_reported[joint])
    left = {"stated": gap.residual[:, joint] / unit, after: compared.heldout[:, joint] / unit}
    clear = gap.clear[:, joint]
    return courses(gap.chain.time, gap.measured[:, joint] / unit, left, joint_unit(compared, joint), clear)


def courses(
    time: Floats, measured: Floats, left: Mapping[str, Floats], unit: str, clear: NDArray[np.bool_]
) -> go.Figure:
    """Return a measured effort (rows,) with each named model's prediction of it, and below that the model's error.

    ``left`` holds the errors (rows,).  They are grey where rows are not ``clear`` (rows,), that is near rests and
    reversals; these may exceed the axis.
    """
    figure = make_subplots(rows=2, cols=1, shared_xaxes=True, vertical_spacing=0.08, subplot_titles=("effort", "error"))
    kept = thinned(time.size)
    figure.add_scatter(
        x=time[kept], y=measured[kept], name="measured", line={"color": MEASURED, "width": 4}, row=1, col=1
    )
    for (name, residual), colour in zip(left.items(), itertools.cycle(MODELS)):
        line = {"color": colour, "width": 1.3}
        figure.add_scatter(x=time[kept], y=(measured - residual)[kept], name=name, line=line, row=1, col=1)
        for own, shade, width in ((~clear, INK, 0.5), (clear, colour, 1.3)):
            error = np.where(own, residual, np.nan)[kept]
            shown = {"color": shade, "width": width}
            figure.add_scatter(x=time[kept], y=error, name=name, line=shown, showlegend=False, row=2, col=1)
    counted = [np.abs(residual[clear]) for residual in left.values() if np.any(clear)]
    top = ROOM * max((float(np.quantile(own, COUNTED)) for own in counted), default=0.0)
    figure.update_yaxes(title_text=unit)
    if top > 0.0:
        figure.update_yaxes(range=[-top, top], row=2, col=1)
    figure.update_xaxes(title_text="time, s", row=2, col=1)
    return styled(figure, 520)


def bars(joints: Sequence[str], errors: Mapping[str, Sequence[float]], noise: Sequence[float], unit: str) -> go.Figure:
    """Return bars of the RMS error of each named model at every joint, beside the sensor's noise."""
    figure = go.Figure()
    for (name, values), colour in zip(errors.items(), itertools.cycle(MODELS)):
        figure.add_bar(name=name, x=list(joints), y=list(values), marker_color=colour)
    figure.add_bar(name="sensor noise", x=list(joints), y=list(noise), marker_color=NOISE)
    figure.update_yaxes(title_text=f"RMS error, {unit}", rangemode="tozero")
    return styled(figure, 320)


def joint_unit(compared: Compared, joint: int) -> str:
    """Return the unit that an examined joint (its index) reports in."""
    name = compared.gap.robot.joints[joint]
    return next(error.unit for error in compared.joints if error.joint == name)


def thinned(count: int) -> slice:
    """Return which of ``count`` points to draw: evenly spaced ones, at most MOST_POINTS."""
    return slice(None, None, max(1, -(-int(count) // MOST_POINTS)))


def styled(figure: go.Figure, height: int) -> go.Figure:
    """Return a figure in the page's style."""
    grid = {"gridcolor": "rgba(128,128,128,0.25)", "zerolinecolor": "rgba(128,128,128,0.5)"}
    figure.update_xaxes(**grid)
    figure.update_yaxes(**grid)
    return figure.update_layout(
        height=height,
        margin={"l": 60, "r": 15, "t": 60, "b": 50},
        paper_bgcolor="rgba(0,0,0,0)",
        plot_bgcolor="rgba(0,0,0,0)",
        font={"color": INK, "family": "system-ui, sans-serif", "size": 13},
        legend={"orientation": "h", "yanchor": "bottom", "y": 1.06, "font": {"size": 12}},
        barmode="group",
    )


def figure_html(figure: go.Figure, name: str) -> str:
    """Return a figure as HTML without the plotting script, which the page includes once."""
    return str(
        figure.to_html(
            full_html=False, include_plotlyjs=False, div_id=name, config={"displayModeBar": False, "responsive": True}
        )
    )
