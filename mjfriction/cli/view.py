"""``mjfriction view``: open a recording."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated
from urllib.parse import quote

import typer

SCREENS = ("DISPLAY", "WAYLAND_DISPLAY")
WEB_PORT, GRPC_PORT = 9090, 9876

Folder = Annotated[Path, typer.Argument(metavar="DIR", help="A folder of results, or a recording.", show_default=False)]
Serve = Annotated[bool, typer.Option("--serve", help="Serve it to browsers, here and on other machines, until Ctrl-C.")]


def view(folder: Folder, serve: Serve = False) -> None:
    """Open the Rerun recording of a result, or serve it to browsers.

    Example: mjfriction view result
    """
    import os
    import socket
    import sys

    from mjfriction.errors import InputError

    if folder.is_file() and folder.suffix != ".rrd":
        raise InputError(f"{folder}: is no recording; give a folder of results, or a file that ends in .rrd")
    recording = folder / "recording.rrd" if folder.suffix != ".rrd" else folder
    if not recording.is_file():
        raise InputError(f"{recording}: there is no such recording; run mjfriction diagnose ... --out {folder} first")
    if not serve and sys.platform.startswith("linux") and not any(os.environ.get(name) for name in SCREENS):
        raise InputError(f"there is no screen here; mjfriction view {folder} --serve shows it in a browser")
    way = []
    if serve:
        print("Open in a browser; Ctrl-C ends it.")
        for place, host in (("here", "localhost"), ("elsewhere", socket.gethostname())):
            proxy = quote(f"rerun+http://{host}:{GRPC_PORT}/proxy", safe="")
            print(f"  {place}: http://{host}:{WEB_PORT}?url={proxy}", flush=True)
        way = ["--serve-web", "--web-viewer-port", str(WEB_PORT), "--port", str(GRPC_PORT)]
    # In this process's place, so that what stops it stops Rerun.
    os.execv(sys.executable, [sys.executable, "-m", "rerun", *way, str(recording)])
