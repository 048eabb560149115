"""Writing the four files of a diagnosis or an identification to one folder."""

from __future__ import annotations

from pathlib import Path

import pyarrow.parquet

from mjfriction.diagnose.tell.outcome import Diagnosis
from mjfriction.identify.outcome import Identification
from mjfriction.report.folder import whole_folder
from mjfriction.report.html import identified_html, report_html
from mjfriction.report.rerun_view import write_identified_recording, write_recording
from mjfriction.report.result import Report, make_report, report_json
from mjfriction.robot.files import write_robot

NEXT_EXPERIMENT = "next_experiment.parquet"
SOMETIMES = (NEXT_EXPERIMENT,)  # files that not every run writes


def write_results(diagnosis: Diagnosis, report: Report, folder: Path) -> None:
    """Write report.json, report.html, recording.rrd, robot.toml with the model file it names, and
    next_experiment.parquet if the diagnosis has a motion that would distinguish causes.
    """
    (folder / "report.json").write_text(report_json(report), encoding="utf-8")
    (folder / "report.html").write_text(report_html(diagnosis, report), encoding="utf-8")
    write_recording(diagnosis, report, folder / "recording.rrd")
    if diagnosis.next_experiment is not None:
        pyarrow.parquet.write_table(diagnosis.next_experiment.trajectory.table(), folder / NEXT_EXPERIMENT)
    source = diagnosis.gap.log.name
    made = "As stated: nothing was fitted to" if report.refused else "Extended by mjfriction from"
    write_robot(diagnosis.robot, folder, comment=f"{made} {source}.\n{report.summary}")


def save_diagnosis(diagnosis: Diagnosis, folder: Path | str) -> Report:
    """Write the files of ``mjfriction diagnose`` to a folder, all or none, and return the report.

    Raises :class:`~mjfriction.errors.OutputError` if the folder cannot be written.
    """
    report = make_report(diagnosis)
    with whole_folder(Path(folder), SOMETIMES) as draft:
        write_results(diagnosis, report, draft)
    return report


def write_identified(identification: Identification, report: Report, folder: Path) -> None:
    """Write report.json, report.html, recording.rrd and robot.toml (with its model file) of an identification."""
    (folder / "report.json").write_text(report_json(report), encoding="utf-8")
    (folder / "report.html").write_text(identified_html(identification, report), encoding="utf-8")
    write_identified_recording(identification, report, folder / "recording.rrd")
    source = identification.gap.log.name
    write_robot(identification.robot, folder, comment=f"Identified by mjfriction from {source}.\n{report.summary}")
