"""recording.rrd: the arm in motion and, in one tab per joint, what was measured and what each model predicts."""

from __future__ import annotations

import itertools
import uuid
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import rerun as rr
import rerun.blueprint as rrb
from plotly.colors import hex_to_rgb

from mjfriction.diagnose.tell.free_run import FreeRun
from mjfriction.diagnose.tell.outcome import Diagnosis
from mjfriction.errors import SimulationError
from mjfriction.identify.comparison import Comparison
from mjfriction.identify.gap import Gap
from mjfriction.identify.measure import gap_of
from mjfriction.identify.outcome import Identification
from mjfriction.record.log import Floats
from mjfriction.report.digits import digits
from mjfriction.report.entity import place_of
from mjfriction.report.figures import MEASURED, MODELS
from mjfriction.report.friction_plane import plane_view, send_plane
from mjfriction.report.result import Report
from mjfriction.report.scene_view import scene_along, scene_view, send_scene
from mjfriction.robot.effort import friction_states
from mjfriction.sim.scene import Scene

CLOCK = "log_time_s"
NAMESPACE = uuid.UUID("6f1f2f0e-6f0c-4d4e-9d6b-6d6a66726963")
RATE = 200.0  # Hz, of time series that are not sampled at the rows; enough for viewing
MOST_SAMPLES = 40_000  # of a time series: it keeps ten minutes of six joints with their states below 100 MB


@dataclass(frozen=True)
class _Model:
    """A named model: its own ``gap``, and its residual ``left`` (rows, joints), held-out if the model was fitted."""

    name: str
    gap: Gap
    left: Floats


def write_recording(diagnosis: Diagnosis, report: Report, path: Path) -> None:
    """Write the recording of a diagnosis: the stated robot and the extended one."""
    found = [finding.shown_at for finding in diagnosis.findings]
    models = [_stated(diagnosis.gap), _Model("extended", gap_of(diagnosis.robot, diagnosis.gap), diagnosis.heldout)]
    _write(models, found, _findings_text(report), report.summary, path, diagnosis.free_run)


def write_identified_recording(identification: Identification, report: Report, path: Path) -> None:
    """Write the recording of an identification: the stated robot and the identified one."""
    gap = identification.gap
    models = [_stated(gap), _Model("identified", gap_of(identification.robot, gap), identification.heldout)]
    _write(models, [], _laws_text(report), report.summary, path)


def write_compared_recording(comparison: Comparison, path: Path) -> None:
    """Write the recording of several robots compared with one log."""
    models = [_Model(name, gap, gap.residual) for name, gap in zip(comparison.names, comparison.gaps, strict=True)]
    text = f"# {' · '.join(comparison.names)}\n\n{comparison.summary}"
    _write(models, [], text, comparison.summary, path)


def _stated(gap: Gap) -> _Model:
    return _Model("stated", gap, gap.residual)


def _write(
    models: Sequence[_Model], first: Sequence[str], text: str, summary: str, path: Path, run: FreeRun | None = None
) -> None:
    gap = models[0].gap
    joints = list(dict.fromkeys([*first, *(gap.robot.joints[joint] for joint in gap.examined)]))
    identity = uuid.uuid5(NAMESPACE, f"{gap.robot.name} {gap.log.source} {summary}")
    stream = rr.RecordingStream("mjfriction", recording_id=identity, send_properties=False)
    drawn = _scene(gap)
    last = models[-1].gap
    states = friction_states(last.robot, last.body, gap.motion)
    tabs = [
        _tab(
            name,
            current=gap.robot.joint(name).actuator.effort_per_ampere is not None,
            states=sorted(states.get(name, {})),
            driven=run is not None,
        )
        for name in joints
    ]
    stream.save(path, default_blueprint=_blueprint(tabs, drawn[1] if drawn else None))
    if drawn is not None:
        send_scene(stream, *drawn, CLOCK)
    stream.log("findings", rr.TextDocument(text, media_type="text/markdown"), static=True)
    thin = thinned_to_see(gap.motion.time)
    for name in joints:
        _send_joint(stream, models, name)
        if run is not None:
            _send_run(stream, run, models, name)
        for law, course in states.get(name, {}).items():
            for k, column in enumerate(course[thin].T):
                send(stream, f"{place_of(name)}/state/{law}/{k + 1}", gap.motion.time[thin], column)
    stream.flush()
    stream.disconnect()


def _send_joint(stream: rr.RecordingStream, models: Sequence[_Model], name: str) -> None:
    gap = models[0].gap
    joint = gap.robot.joints.index(name)
    time, measured, velocity = gap.chain.time, gap.measured[:, joint], gap.at_rows("velocity")[:, joint]
    colours = [_rgb(MEASURED), *itertools.islice(itertools.cycle(map(_rgb, MODELS)), len(models))]
    place = place_of(name)
    told = {"measured": measured} | {model.name: measured - model.left[:, joint] for model in models}
    for quantity, unit in (("torque", 1.0), ("current", gap.robot.joint(name).actuator.effort_per_ampere)):
        if unit is not None:
            for (source, course), colour in zip(told.items(), colours, strict=True):
                send(stream, f"{place}/{quantity}/{place_of(source)}", time, course / unit, colour)
    friction = {model.name: model.gap.chain.rows(model.gap.effort.friction[:, joint]) for model in models}
    last = models[-1]
    left_to_friction = friction[last.name] + last.left[:, joint]
    for model, colour in zip(models, colours[1:], strict=True):
        send(stream, f"{place}/error/{place_of(model.name)}", time, model.left[:, joint], colour)
    send(stream, f"{place}/velocity", time, velocity)
    sliding = gap.body.sliding[joint]
    shown = {"measured": left_to_friction, **friction}
    send_plane(
        stream,
        f"{place}/friction",
        CLOCK,
        time,
        velocity,
        shown,
        colours,
        ("m/s", "N") if sliding else ("rad/s", "N·m"),
    )


def _send_run(stream: rr.RecordingStream, run: FreeRun, models: Sequence[_Model], name: str) -> None:
    # Points rather than a line, which would connect one run's end to the next one's start.
    joint = models[0].gap.robot.joints.index(name)
    moments = (run.begin[:, None] + run.time).ravel()
    for model, off, colour in zip(models, (run.stated, run.extended), MODELS, strict=False):
        entity = f"{place_of(name)}/driven/{place_of(model.name)}"
        stream.log(entity, rr.SeriesPoints(colors=[_rgb(colour)], marker_sizes=[1.5]), static=True)
        send(stream, entity, moments, off[..., joint].ravel())


def _rgb(colour: str) -> tuple[int, int, int]:
    red, green, blue = hex_to_rgb(colour)
    return red, green, blue


def thinned_to_see(time: Floats) -> slice:
    """Return which samples at evenly spaced times (n,) a recording keeps."""
    rate = (time.size - 1) / max(float(time[-1] - time[0]), 1e-300)
    return slice(None, None, max(1, round(rate / RATE), -(-time.size // MOST_SAMPLES)))


def send(
    stream: rr.RecordingStream, entity: str, time: Floats, values: Floats, colour: tuple[int, int, int] | None = None
) -> None:
    """Write a time series, (n,) each, to a recording; where no colour is given, the viewer picks one."""
    if colour is not None:
        stream.log(entity, rr.SeriesLines(colors=[colour]), static=True)
    stream.send_columns(
        entity,
        indexes=[rr.TimeColumn(CLOCK, duration=time)],
        columns=rr.Scalars.columns(scalars=np.asarray(values)),
    )


def _scene(gap: Gap) -> tuple[Floats, Scene] | None:
    try:
        return scene_along(gap.robot, gap.motion.time, gap.motion.position)
    except SimulationError:
        return None  # a model that MuJoCo cannot read can still be diagnosed; only its picture is missing


def _tab(name: str, *, current: bool, states: Sequence[str], driven: bool) -> rrb.Horizontal:
    place = place_of(name)
    courses = [rrb.TimeSeriesView(origin=f"{place}/torque", name="torque")]
    if current:
        courses.append(rrb.TimeSeriesView(origin=f"{place}/current", name="current"))
    courses += [
        rrb.TimeSeriesView(origin=f"{place}/error", name="error"),
        rrb.TimeSeriesView(origin=f"{place}/velocity", name="velocity"),
    ]
    if driven:
        courses.append(rrb.TimeSeriesView(origin=f"{place}/driven", name="driven freely: off the machine's course"))
    beside: list[rrb.View] = [plane_view(f"{place}/friction")]
    beside += [rrb.TimeSeriesView(origin=f"{place}/state/{law}", name=f"states of {law}") for law in states]
    return rrb.Horizontal(rrb.Vertical(*courses), rrb.Vertical(*beside), name=name, column_shares=[3, 2])


def _blueprint(tabs: Sequence[rrb.Container], scene: Scene | None) -> rrb.Blueprint:
    text = rrb.TextDocumentView(origin="findings", name="findings")
    left = rrb.Vertical(text, scene_view(scene)) if scene is not None else text
    return rrb.Blueprint(rrb.Horizontal(left, rrb.Tabs(*tabs), column_shares=[1, 3]), collapse_panels=True)


def _findings_text(report: Report) -> str:
    lines = [f"# {report.verdict}", report.summary]
    for finding in report.findings:
        lines += [f"## {finding.cause}" + (f" at {finding.joint}" if finding.joint else ""), finding.evidence]
        lines += [
            f"- {p.name} = {digits(p.value, p.unit)} {'' if p.unit == '1' else p.unit}" for p in finding.parameters
        ]
    return "\n\n".join(lines)


def _laws_text(report: Report) -> str:
    lines = ["# identified", report.summary]
    for law in report.identified:
        lines += [f"## {law.joint}: {law.law}"]
        lines += [
            f"- {p.name} = {digits(p.value, p.unit)} {'' if p.unit == '1' else p.unit} {p.note}" for p in law.parameters
        ]
    return "\n\n".join(lines)
