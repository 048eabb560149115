"""``mjfriction compare``: several robots compared with one log, side by side."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Annotated

import typer

from mjfriction.cli.logs import read_logs
from mjfriction.cli.options import Json, LogPath, MapSource
from mjfriction.cli.progress import telling
from mjfriction.cli.show import show

Robots = Annotated[
    list[str],
    typer.Option("--robot", metavar="R", help="A robot.toml or a bundled robot; give one each.", show_default=False),
]
Out = Annotated[
    Path | None, typer.Option("--out", metavar="DIR", help="Folder for tables, page and recording.", show_default=False)
]


Simulated = Annotated[
    float | None,
    typer.Option(metavar="S", help="Drive the robots by the log's efforts, S seconds at a time; inf for the whole."),
]


def compare(
    log: LogPath,
    robot: Robots,
    out: Out = None,
    simulated: Simulated = None,
    map_: MapSource = None,
    json: Json = False,
) -> None:
    """Show the RMS error of each robot per joint, in torque and in current, side by side.

    With --simulated, also shows the position error of each when driven by the log's efforts. With --out, writes
    comparison.json, report.html and recording.rrd.

    Example: mjfriction compare run2.parquet --robot arm/robot.toml --robot result/robot.toml
    """
    from mjfriction.identify.comparison import compare_robots
    from mjfriction.report.comparison import comparison_table, write_comparison
    from mjfriction.report.folder import whole_folder
    from mjfriction.report.text import print_comparison
    from mjfriction.robot.files import read_robot

    with telling() as tell:
        robots = [(name, read_robot(source)) for name, source in zip(short_names(robot), robot, strict=True)]
        comparison = compare_robots(read_logs([log], robots[0][1].joints, map_), robots, tell, simulated=simulated)
    if out is not None:
        with whole_folder(out) as folder, telling() as tell:
            tell("writing the report")
            write_comparison(comparison, folder)
    if json:
        import json as writer

        typer.echo(writer.dumps(comparison_table(comparison), indent=2, ensure_ascii=False))
        return
    show(partial(print_comparison, comparison), out)


def short_names(sources: list[str]) -> list[str]:
    """Return short names for robots: the file's, or the folder's where the file is robot.toml, as in results.

    Where two short names are the same, the full sources are returned.
    """
    paths = [Path(source) for source in sources]
    short = [path.absolute().parent.name if path.name == "robot.toml" else path.stem for path in paths]
    return short if len(set(short)) == len(short) else list(sources)
