"""The picture of the free runs: how the stated and the extended robot drift off the machine's path."""

from __future__ import annotations

import numpy as np
import plotly.graph_objects as go
from plotly.subplots import make_subplots

from mjfriction.diagnose.tell.free_run import FreeRun
from mjfriction.record.log import Floats
from mjfriction.report.figures import AFTER, BEFORE, INK, styled

SIDES = (("as stated", BEFORE), ("extended", AFTER))


def free_run_figure(run: FreeRun, joint: int, *, sliding: bool) -> go.Figure:
    """Return the position error of a joint (its index) in every free run, as stated and extended, and its ± RMS."""
    figure = make_subplots(rows=1, cols=2, shared_yaxes=True, subplot_titles=[name for name, _ in SIDES])
    time = np.append(0.0, run.time)
    for k, ((_, colour), off) in enumerate(zip(SIDES, (run.stated, run.extended), strict=True), start=1):
        # Each run starts where the machine was, with no error.  NaN between two runs breaks the line that draws all.
        courses = 1e3 * np.pad(off[..., joint], ((0, 0), (1, 0)))
        apart = np.pad(courses, ((0, 0), (0, 1)), constant_values=np.nan).ravel()
        line = {"color": colour, "width": 1}
        along = np.tile(np.append(time, np.nan), courses.shape[0])
        figure.add_scatter(x=along, y=apart, mode="lines", line=line, opacity=0.5, row=1, col=k)
        for bound in _spread(courses):
            figure.add_scatter(x=time, y=bound, mode="lines", line={"color": INK, "width": 3}, row=1, col=k)
    figure.update_xaxes(title_text="time since the run began, s")
    figure.update_yaxes(title_text=f"off the machine's course, {'mm' if sliding else 'mrad'}", col=1)
    figure.update_layout(showlegend=False)
    return styled(figure, 380)


def _spread(courses: Floats) -> tuple[Floats, Floats]:
    rms = np.sqrt(np.mean(np.square(courses), axis=0))
    return rms, -rms
