"""recording.rrd: the same pictures for Rerun, to scroll through in time."""

from __future__ import annotations

import uuid
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from mjfriction.diagnose.outcome import Diagnosis
from mjfriction.errors import SimulationError
from mjfriction.identify.gap import Gap
from mjfriction.identify.outcome import Identification
from mjfriction.record.log import Floats
from mjfriction.report.compared import Compared
from mjfriction.report.result import Report
from mjfriction.report.scene_view import scene_along, scene_view, send_scene
from mjfriction.sim.scene import Scene

CLOCK = "log_time_s"
NAMESPACE = uuid.UUID("6f1f2f0e-6f0c-4d4e-9d6b-6d6a66726963")


def write_recording(diagnosis: Diagnosis, report: Report, path: Path) -> None:
    """Write a recording of every examined joint: effort measured, stated and extended, both errors, and velocity."""
    found = [finding.shown_at for finding in diagnosis.findings]
    _write(diagnosis, "extended", _findings_text(report), found, report.summary, path)


def write_identified_recording(identification: Identification, report: Report, path: Path) -> None:
    """Write a recording of every examined joint: effort measured, stated and identified, both errors, and velocity."""
    _write(identification, "identified", _laws_text(report), [], report.summary, path)


def _write(compared: Compared, after: str, text: str, first: list[str], summary: str, path: Path) -> None:
    left = {"stated": compared.gap.residual, after: compared.heldout}
    order = list(dict.fromkeys(first + [error.joint for error in compared.joints]))
    write_courses(compared.gap, left, order, text, summary, path)


def write_courses(
    gap: Gap, left: Mapping[str, Floats], order: Sequence[str], text: str, summary: str, path: Path
) -> None:
    """Write a recording of efforts measured and predicted, errors and velocities, one tab a joint in ``order``.

    ``left`` are what each named model leaves, (rows, joints); ``text`` is a page in Markdown beside them; ``summary``
    tells the recording from others of the same log.
    """
    identity = uuid.uuid5(NAMESPACE, f"{gap.robot.name} {gap.log.source} {summary}")
    stream = rr.RecordingStream("mjfriction", recording_id=identity, send_properties=False)
    drawn = _scene(gap)
    stream.save(path, default_blueprint=_blueprint(order, drawn[1] if drawn else None))
    if drawn is not None:
        send_scene(stream, *drawn, CLOCK)
    stream.log("findings", rr.TextDocument(text, media_type="text/markdown"), static=True)
    for joint in gap.examined:
        name = gap.robot.joints[joint]
        unit = float(gap.per_reported[joint])
        measured = gap.measured[:, joint] / unit
        send(stream, f"{name}/effort/measured", gap.chain.time, measured)
        for model, residual in left.items():
            send(stream, f"{name}/effort/{model}", gap.chain.time, measured - residual[:, joint] / unit)
            send(stream, f"{name}/error/{model}", gap.chain.time, residual[:, joint] / unit)
        send(stream, f"{name}/velocity", gap.chain.time, gap.chain.rows(gap.motion.velocity[:, joint]))
    stream.flush()
    stream.disconnect()


def send(stream: rr.RecordingStream, entity: str, time: Floats, values: Floats) -> None:
    """Put a course of numbers, (n,) each, into a recording."""
    stream.send_columns(
        entity,
        indexes=[rr.TimeColumn(CLOCK, duration=time)],
        columns=rr.Scalars.columns(scalars=np.asarray(values)),
    )


def _scene(gap: Gap) -> tuple[Floats, Scene] | None:
    try:
        return scene_along(gap.robot, gap.motion.time, gap.motion.position)
    except SimulationError:
        return None  # a model that MuJoCo cannot read is diagnosed all the same; only its picture is missing


def _blueprint(order: Sequence[str], scene: Scene | None) -> rrb.Blueprint:
    tabs = [
        rrb.Vertical(
            rrb.TimeSeriesView(origin=f"{name}/effort", name="effort"),
            rrb.TimeSeriesView(origin=f"{name}/error", name="error"),
            rrb.TimeSeriesView(origin=f"{name}/velocity", name="velocity"),
            name=name,
        )
        for name in order
    ]
    text = rrb.TextDocumentView(origin="findings", name="findings")
    left = rrb.Vertical(text, scene_view(scene)) if scene is not None else text
    return rrb.Blueprint(rrb.Horizontal(left, rrb.Tabs(*tabs), column_shares=[1, 3]), collapse_panels=True)


def _findings_text(report: Report) -> str:
    lines = [f"# {report.verdict}", report.summary]
    for finding in report.findings:
        lines += [f"## {finding.cause}" + (f" at {finding.joint}" if finding.joint else ""), finding.evidence]
        lines += [f"- {p.name} = {p.value:.4g} {'' if p.unit == '1' else p.unit}" for p in finding.parameters]
    return "\n\n".join(lines)


def _laws_text(report: Report) -> str:
    lines = ["# identified", report.summary]
    for law in report.identified:
        lines += [f"## {law.joint}: {law.law}"]
        lines += [f"- {p.name} = {p.value:.4g} {'' if p.unit == '1' else p.unit} {p.note}" for p in law.parameters]
    return "\n\n".join(lines)
