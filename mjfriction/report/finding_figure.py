"""The picture that proves a finding: the residual against the covariate the cause acts on, before and after."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import plotly.graph_objects as go
from numpy.typing import NDArray
from plotly.subplots import make_subplots
from scipy.signal import lombscargle

from mjfriction.diagnose.tell.outcome import Diagnosis, Finding
from mjfriction.identify.gap import Gap
from mjfriction.identify.structure import covariate_rows
from mjfriction.record.log import Floats
from mjfriction.record.reversals import travel_since_turn
from mjfriction.report.figures import AFTER, BEFORE, INK, joint_unit, styled, thinned

SIDES = (("without this cause", BEFORE), ("with it", AFTER))
BINS = 40
UNITS = {
    "velocity": ("rad/s", "m/s"),
    "position": ("rad", "m"),
    "acceleration": ("rad/s²", "m/s²"),
    "effort": ("N·m", "N"),
    "load": ("N·m", "N"),
    "time": ("s", "s"),
}
LOOP_SECONDS = 4.0
OCTAVES = 1.3  # how far a spectrum extends above the wavenumber that was found
PER_LOBE = 6.0  # points of a spectrum per resolvable step in wavenumber, 2π over the stroke


@dataclass(frozen=True)
class _Seen:
    """A finding's joint, and the residuals ``left`` without the finding and with it, (2, rows), in ``unit``."""

    gap: Gap
    joint: int
    left: Floats
    unit: str

    @property
    def length(self) -> str:
        return "m" if self.gap.body.sliding[self.joint] else "rad"

    @property
    def way(self) -> Floats:
        return self.gap.at_rows("forward")[:, self.joint]


def finding_figure(diagnosis: Diagnosis, finding: Finding) -> go.Figure:
    """Return the picture of a finding.

    For most causes it shows the held-out residual at the joint where the cause shows most, against the covariate it
    acts on: with all other causes but this one, and with it too; rows near reversals and at rest are grey.  A residual
    whose sign turns with the direction of motion is multiplied by that direction.  Waves are drawn as a spectrum along
    the stroke, a build-up of friction against the travel since the last reversal, and a delay as the loop of measured
    over predicted effort.
    """
    gap = diagnosis.gap
    joint = gap.robot.joints.index(finding.shown_at)
    per_reported = abs(float(gap.per_reported[joint]))
    left = np.stack([finding.without, diagnosis.heldout[:, joint]]) / per_reported
    seen = _Seen(gap, joint, left, joint_unit(diagnosis, joint))
    if finding.picture == "loop":
        return _loop(seen, gap.measured[:, joint] / per_reported)
    if finding.picture == "spectrum":
        return _spectrum(seen, seen.left, finding)
    if finding.picture == "turned_spectrum":
        return _spectrum(seen, seen.left * seen.way, finding)
    if finding.picture == "travel":
        return _travel(seen)
    values = covariate_rows(gap, joint, finding.covariate)
    label = f"{finding.covariate}, {UNITS[finding.covariate][gap.body.sliding[joint]]}"
    turned = finding.picture == "turned"
    return _panels(seen, values, seen.left * seen.way if turned else seen.left, label, against=turned)


def _panels(seen: _Seen, values: Floats, left: Floats, label: str, *, against: bool, log: bool = False) -> go.Figure:
    figure = make_subplots(rows=1, cols=2, shared_yaxes=True, subplot_titles=[name for name, _ in SIDES])
    shown = values > 0.0 if log else np.ones(values.size, dtype=bool)
    clear = seen.gap.clear[:, seen.joint]
    if log:
        clear = shown  # a build-up shows near reversals, where rows are not clear
    for k, ((_, colour), residual) in enumerate(zip(SIDES, left, strict=True), start=1):
        for rows, shade, faint in ((shown & ~clear, INK, 0.2), (shown & clear, colour, 0.4)):
            kept = np.flatnonzero(rows)[thinned(int(np.count_nonzero(rows)))]
            marker = {"size": 3, "color": shade, "opacity": faint}
            figure.add_scatter(x=values[kept], y=residual[kept], mode="markers", marker=marker, row=1, col=k)
        centre, mean = _binned(values[clear], residual[clear])
        figure.add_scatter(x=centre, y=mean, mode="lines", line={"color": INK, "width": 3}, row=1, col=k)
    figure.update_xaxes(title_text=label, type="log" if log else "linear")
    figure.update_yaxes(title_text=f"error{' against the motion' if against else ''}, {seen.unit}", col=1)
    figure.update_layout(showlegend=False)
    return styled(figure, 380)


def _travel(seen: _Seen) -> go.Figure:
    travel, way = _since_the_turn(seen.gap, seen.joint)
    label = f"travel since the joint turned, {seen.length}"
    return _panels(seen, travel, seen.left * way, label, against=True, log=True)


def _since_the_turn(gap: Gap, joint: int) -> tuple[Floats, Floats]:
    # The joint's travel since its last reversal, 0 before a piece's first one, and its direction, −1 to 1, at the rows.
    motion = gap.motion
    velocity, position = motion.velocity[:, [joint]], motion.position[:, [joint]]
    travel, known = travel_since_turn(velocity, position, motion.pieces)
    sample = np.clip(np.searchsorted(motion.time, gap.chain.time), 0, motion.time.size - 1)
    return (known * travel)[sample, 0], (known * np.sign(velocity))[sample, 0]


def _spectrum(seen: _Seen, left: Floats, finding: Finding) -> go.Figure:
    clear = seen.gap.clear[:, seen.joint]
    position = seen.gap.at_rows("position")[clear, seen.joint]
    (found,) = [entry.value for entry in finding.parameters if entry.name == "wavenumber"]
    step = 2.0 * np.pi / float(np.ptp(position)) / PER_LOBE
    wavenumber = np.arange(PER_LOBE * step, found * 2.0**OCTAVES + step, step)
    figure = go.Figure()
    for (name, colour), residual in zip(SIDES, left, strict=True):
        amplitude = np.abs(
            lombscargle(position, residual[clear], wavenumber, normalize="amplitude", floating_mean=True)
        )
        line = {"color": colour, "width": 2}
        figure.add_scatter(x=_waves(seen, wavenumber), y=amplitude, mode="lines", line=line, name=name)
    figure.add_vline(x=float(_waves(seen, np.array(found))), line={"color": INK, "dash": "dot", "width": 1})
    figure.update_xaxes(title_text="waves per metre" if seen.length == "m" else "waves per turn of the joint")
    turned = " against the motion" if finding.picture == "turned_spectrum" else ""
    figure.update_yaxes(title_text=f"amplitude of the error{turned}, {seen.unit}", rangemode="tozero")
    return styled(figure, 380)


def _waves(seen: _Seen, wavenumber: Floats) -> Floats:
    return wavenumber / (2.0 * np.pi) if seen.length == "m" else wavenumber


def _loop(seen: _Seen, measured: Floats) -> go.Figure:
    figure = make_subplots(rows=1, cols=2, shared_yaxes=True, subplot_titles=[name for name, _ in SIDES])
    stretch = _worst_stretch(seen)
    ends = [float(np.min(measured[stretch])), float(np.max(measured[stretch]))]
    for k, ((_, colour), residual) in enumerate(zip(SIDES, seen.left, strict=True), start=1):
        diagonal = {"color": INK, "dash": "dot", "width": 1}
        figure.add_scatter(x=ends, y=ends, mode="lines", line=diagonal, row=1, col=k)
        predicted = (measured - residual)[stretch]
        line = {"color": colour, "width": 1.5}
        figure.add_scatter(x=predicted, y=measured[stretch], mode="lines", line=line, row=1, col=k)
    time = seen.gap.chain.time[stretch]
    figure.update_xaxes(title_text=f"predicted from {time[0]:.1f} to {time[-1]:.1f} s, {seen.unit}")
    figure.update_yaxes(title_text=f"measured effort, {seen.unit}", col=1)
    figure.update_layout(showlegend=False)
    return styled(figure, 380)


def _worst_stretch(seen: _Seen) -> NDArray[np.intp]:
    # The rows of the LOOP_SECONDS, within one piece of motion, in which the squared error without the cause is largest.
    time, piece = seen.gap.chain.time, seen.gap.chain.piece
    error = np.concatenate([[0.0], np.cumsum(np.square(seen.left[0]))])
    past = np.searchsorted(time, time + LOOP_SECONDS)
    past = np.minimum(past, np.searchsorted(piece, piece, side="right"))
    first = int(np.argmax(error[past] - error[:-1]))
    return np.arange(first, past[first])


def _binned(values: Floats, residual: Floats) -> tuple[Floats, Floats]:
    edges = np.unique(np.quantile(values, np.linspace(0.0, 1.0, BINS + 1)))
    place = np.clip(np.searchsorted(edges, values, side="right") - 1, 0, edges.size - 2)
    count = np.maximum(np.bincount(place, minlength=edges.size - 1), 1)
    centre = np.bincount(place, values, minlength=edges.size - 1) / count
    return centre, np.bincount(place, residual, minlength=edges.size - 1) / count
