"""Arguments and options that several verbs share."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

LogPath = Annotated[Path, typer.Argument(metavar="LOG", help="Log file, CSV or Parquet.", show_default=False)]
LogPaths = Annotated[
    list[Path], typer.Argument(metavar="LOG...", help="Log files of one robot, CSV or Parquet.", show_default=False)
]
RobotSource = Annotated[
    str, typer.Option("--robot", metavar="R", help="A robot.toml, or the name of a bundled robot.", show_default=False)
]
Json = Annotated[bool, typer.Option("--json", help="Print the machine's version on standard output.")]
