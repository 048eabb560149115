"""``mjfriction identify``: friction laws and their parameters from a log."""

from __future__ import annotations

import enum
from functools import partial
from pathlib import Path
from typing import Annotated

import typer

from mjfriction.cli.logs import held_masses, read_logs
from mjfriction.cli.options import HeldMasses, Json, LogPaths, MapSource, RobotSource
from mjfriction.cli.progress import WRITING, telling
from mjfriction.cli.show import show
from mjfriction.errors import InputError


class Side(enum.Enum):
    """The side of the gear whose velocity and torque the laws relate."""

    JOINT = "joint"
    MOTOR = "motor"


Out = Annotated[Path, typer.Option("--out", metavar="DIR", help="Folder for the results.", show_default=False)]
LawNames = Annotated[
    list[str] | None,
    typer.Option(
        "--law", metavar="LAW", help="One law for all joints, or JOINT=LAW, repeated; else each gets the one it needs."
    ),
]


def identify(
    logs: LogPaths,
    robot: RobotSource,
    out: Out,
    law: LawNames = None,
    side: Annotated[Side, typer.Option(help="The side of the gear that the laws speak of.")] = Side.JOINT,
    links: Annotated[bool, typer.Option(help="Refit the links' inertias too.")] = True,
    simulated: Annotated[
        float | None,
        typer.Option(metavar="S", help="Refine on simulated motion, S seconds at a time; inf for the whole log."),
    ] = None,
    held: HeldMasses = None,
    map_: MapSource = None,
    json: Json = False,
) -> None:
    """Fit friction laws to a log, with intervals: from free motion, or from passes forward and backward.

    The stated friction is replaced. Writes report.json, report.html, recording.rrd and robot.toml into DIR.

    Example: mjfriction identify run1.parquet --robot arm/robot.toml --law lugre --out identified
    """
    from mjfriction.identify.identification import identify_log
    from mjfriction.report.folder import whole_folder
    from mjfriction.report.identified import make_identified_report
    from mjfriction.report.result import report_json
    from mjfriction.report.text import print_identified
    from mjfriction.report.write import SOMETIMES, write_identified
    from mjfriction.robot.files import read_robot

    with whole_folder(out, SOMETIMES) as folder, telling() as tell:
        stated = read_robot(robot)
        log = read_logs(logs, stated.joints, map_, held_masses(held, logs, stated))
        identification = identify_log(
            log, stated, law=_laws(law or []), side=side.value, links=links, simulated=simulated, tell=tell
        )
        report = make_identified_report(identification)
        tell("writing the report", WRITING)
        write_identified(identification, report, folder)
    if json:
        typer.echo(report_json(report), nl=False)
        return
    show(partial(print_identified, report), out)


def _laws(named: list[str]) -> str | dict[str, str] | None:
    if not any("=" in name for name in named):
        if len(named) > 1:
            raise InputError(f"--law {' --law '.join(named)}: give one law for all joints, or JOINT=LAW for each")
        return named[0] if named else None
    pairs = [name.partition("=") for name in named]
    for (joint, equals, law), name in zip(pairs, named, strict=True):
        if not (joint and equals and law):
            raise InputError(f"--law {name}: beside JOINT=LAW every law needs its joint")
    return {joint: law for joint, _, law in pairs}
