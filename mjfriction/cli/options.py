"""Arguments and options that several verbs share."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

LogPath = Annotated[
    Path, typer.Argument(metavar="LOG", help="Log: CSV, Parquet, npz, mat, HDF5, MCAP.", show_default=False)
]
LogPaths = Annotated[
    list[Path],
    typer.Argument(metavar="LOG...", help="Logs of one robot: CSV, Parquet, npz, mat, HDF5, MCAP.", show_default=False),
]
RobotSource = Annotated[
    str, typer.Option("--robot", metavar="R", help="A robot.toml, or the name of a bundled robot.", show_default=False)
]
MapSource = Annotated[
    str | None,
    typer.Option("--map", metavar="M", help="Columns by other names: a mapping file, or guess.", show_default=False),
]
HeldMasses = Annotated[
    list[float] | None,
    typer.Option(
        "--held",
        metavar="KG",
        help="Mass held during a log, where the robot file's 'held' says; once for each log.",
        show_default=False,
    ),
]
Json = Annotated[bool, typer.Option("--json", help="Print the machine's version on standard output.")]
