"""``mjfriction diagnose``: what the simulation gets wrong, and why."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Annotated

import typer

from mjfriction.cli.logs import held_masses, read_logs
from mjfriction.cli.options import HeldMasses, Json, LogPaths, MapSource, RobotSource
from mjfriction.cli.progress import WRITING, telling
from mjfriction.cli.show import show

Out = Annotated[Path, typer.Option("--out", metavar="DIR", help="Folder for the results.", show_default=False)]
Seed = Annotated[int, typer.Option(help="Sets the resampling behind the intervals of the gains.")]


def diagnose(
    logs: LogPaths,
    robot: RobotSource,
    out: Out,
    held: HeldMasses = None,
    map_: MapSource = None,
    seed: Seed = 0,
    json: Json = False,
) -> None:
    """Find what the robot's model gets wrong, name the cause, and write the extended robot with the proof.

    Writes report.json, report.html, recording.rrd and robot.toml into DIR.

    Example: mjfriction diagnose run1.parquet --robot arm/robot.toml --out result
    """
    report_diagnosis(logs, robot, out, held=held, mapping=map_, seed=seed, json=json)


def report_diagnosis(
    logs: list[Path],
    robot: str,
    out: Path,
    *,
    held: list[float] | None = None,
    mapping: str | None,
    seed: int,
    json: bool,
) -> None:
    """Diagnose, write the four files, and print the report."""
    from mjfriction.diagnose.diagnosis import diagnose_log
    from mjfriction.report.folder import whole_folder
    from mjfriction.report.result import make_report, report_json
    from mjfriction.report.text import print_report
    from mjfriction.report.write import SOMETIMES, write_results
    from mjfriction.robot.files import read_robot

    with whole_folder(out, SOMETIMES) as folder, telling() as tell:
        stated = read_robot(robot)
        log = read_logs(logs, stated.joints, mapping, held_masses(held, logs, stated))
        diagnosis = diagnose_log(log, stated, seed=seed, tell=tell)
        report = make_report(diagnosis)
        tell("writing the report", WRITING)
        write_results(diagnosis, report, folder)
    if json:
        typer.echo(report_json(report), nl=False)
        return
    show(partial(print_report, report), out)
