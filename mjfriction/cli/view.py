"""``mjfriction view``: open a recording."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated
from urllib.parse import quote

import typer

SCREENS = ("DISPLAY", "WAYLAND_DISPLAY")
PORTS = ((9090, 9876), (9091, 9877), (9092, 9878), (9093, 9879))  # pairs to try: for the web page, for its data

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
        free = next((pair for pair in PORTS if all(map(_is_free, pair))), None)
        if free is None:
            listed = ", ".join(str(port) for pair in PORTS for port in pair)
            raise InputError(f"ports {listed} are taken, by other recordings perhaps; end one of them")
        web, data = free
        print("Open in a browser; Ctrl-C ends it.")
        for place, host in (("here", "localhost"), ("elsewhere", socket.gethostname())):
            proxy = quote(f"rerun+http://{host}:{data}/proxy", safe="")
            print(f"  {place}: http://{host}:{web}?url={proxy}", flush=True)
        way = ["--serve-web", "--web-viewer-port", str(web), "--port", str(data)]
        os.environ.setdefault("RUST_LOG", "error")
    # Rerun replaces this process, so that whatever stops this process stops Rerun.
    command = _rerun()
    os.execv(command[0], [*command, *way, str(recording)])


def _is_free(port: int) -> bool:
    import socket

    with socket.socket() as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind(("", port))
        except OSError:
            return False
    return True


def _rerun() -> list[str]:
    # Rerun's program itself, where it is installed: the module rerun would run it as a child process that outlives it.
    import sys
    from importlib.util import find_spec

    spec = find_spec("rerun_cli")
    program = Path(spec.origin).with_name("rerun") if spec is not None and spec.origin is not None else Path()
    return [str(program)] if program.is_file() else [sys.executable, "-m", "rerun"]
