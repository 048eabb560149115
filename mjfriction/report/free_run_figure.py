"""The picture of the proof in motion: how the stated and the extended robot leave the machine's course."""

from __future__ import annotations

import numpy as np
import plotly.graph_objects as go
from plotly.subplots import make_subplots

from mjfriction.diagnose.free_run import FreeRun
from mjfriction.record.log import Floats
from mjfriction.report.figures import AFTER, BEFORE, INK, styled

SIDES = (("as stated", BEFORE), ("extended", AFTER))


def free_run_figure(run: FreeRun, joint: int, *, sliding: bool) -> go.Figure:
    """Return how far a joint (its index) is off in every free run, as stated and extended, and the RMS of all."""
    figure = make_subplots(rows=1, cols=2, shared_yaxes=True, subplot_titles=[name for name, _ in SIDES])
    time = np.append(0.0, run.time)
    for k, ((_, colour), off) in enumerate(zip(SIDES, (run.stated, run.extended), strict=True), start=1):
        # From where the machine was; a break between two runs keeps them apart in one line.
        courses = 1e3 * np.pad(off[..., joint], ((0, 0), (1, 0)))
        apart = np.pad(courses, ((0, 0), (0, 1)), constant_values=np.nan).ravel()
        line = {"color": colour, "width": 1}
        along = np.tile(np.append(time, np.nan), courses.shape[0])
        figure.add_scattergl(x=along, y=apart, mode="lines", line=line, opacity=0.5, row=1, col=k)
        for bound in _spread(courses):
            figure.add_scatter(x=time, y=bound, mode="lines", line={"color": INK, "width": 3}, row=1, col=k)
    figure.update_xaxes(title_text="time since the run began, s")
    figure.update_yaxes(title_text=f"off the machine's course, {'mm' if sliding else 'mrad'}", col=1)
    figure.update_layout(showlegend=False)
    return styled(figure, 380)


def _spread(courses: Floats) -> tuple[Floats, Floats]:
    rms = np.sqrt(np.mean(np.square(courses), axis=0))
    return rms, -rms
