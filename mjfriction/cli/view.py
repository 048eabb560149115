"""``mjfriction view``: open a recording."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

Folder = Annotated[Path, typer.Argument(metavar="DIR", help="A folder of results, or a recording.", show_default=False)]


def view(folder: Folder) -> None:
    """Open the Rerun recording of a result.

    Example: mjfriction view result
    """
    import subprocess
    import sys

    from mjfriction.errors import InputError

    recording = folder / "recording.rrd" if folder.suffix != ".rrd" else folder
    if not recording.is_file():
        raise InputError(f"{recording}: there is no such recording; run mjfriction diagnose ... --out {folder} first")
    raise typer.Exit(subprocess.call([sys.executable, "-m", "rerun", str(recording)]))
