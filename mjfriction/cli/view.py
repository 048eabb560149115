"""``mjfriction view``: open a recording."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

Folder = Annotated[Path, typer.Argument(metavar="DIR", help="A folder of results, or a recording.", show_default=False)]
Serve = Annotated[bool, typer.Option("--serve", help="Serve it to browsers, here and on other machines, until Ctrl-C.")]


def view(folder: Folder, serve: Serve = False) -> None:
    """Open the Rerun recording of a result, or serve it to browsers.

    Example: mjfriction view result
    """
    import subprocess
    import sys

    from mjfriction.errors import InputError

    recording = folder / "recording.rrd" if folder.suffix != ".rrd" else folder
    if not recording.is_file():
        raise InputError(f"{recording}: there is no such recording; run mjfriction diagnose ... --out {folder} first")
    way = ["--serve-web"] if serve else []
    raise typer.Exit(subprocess.call([sys.executable, "-m", "rerun", *way, str(recording)]))
