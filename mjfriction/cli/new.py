"""``mjfriction new``: a robot file to start from."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from mjfriction.cli.options import MapSource

Model = Annotated[str, typer.Argument(metavar="MODEL", help="The robot's URDF or MJCF.", show_default=False)]
Out = Annotated[Path, typer.Option("--out", metavar="R.toml", help="The robot file to write.", show_default=False)]
LogOption = Annotated[
    Path | None,
    typer.Option("--log", metavar="LOG", help="List only the joints that this log has.", show_default=False),
]


def new(model: Model, out: Out, log: LogOption = None, map_: MapSource = None) -> None:
    """Draft a robot file from a URDF or MJCF, with a place for everything else you know.

    Example: mjfriction new arm.urdf --log run1.parquet --out my_arm.toml
    """
    from mjfriction.cli.logs import read_logs
    from mjfriction.errors import InputError, OutputError
    from mjfriction.report.folder import whole_file
    from mjfriction.robot.draft import draft_robot, joints_of
    from mjfriction.robot.files import read_robot

    if out.exists():
        raise OutputError(f"{out}: is there already, and may hold what you know; give another name")
    if map_ is not None and log is None:
        raise InputError("--map names the columns of a log; give the log with --log, or leave --map out")
    wanted = read_logs([log], (), map_).joints if log is not None else None
    text = draft_robot(model, out.parent, wanted)
    with whole_file(out) as draft:
        draft.write_text(text, encoding="utf-8")
        robot = read_robot(draft)
    typer.echo(f"written: {out}, with {len(robot.joints)} joints: {', '.join(robot.joints)}")
    others = [name for name in joints_of(model) if name not in robot.joints]
    if others:
        typer.echo(f"Left out: {', '.join(others)}")
    if log is None:
        typer.echo(
            "Take out of it the joints that your logs lack; like a gripper's, they are held where the model has them."
        )
    typer.echo("Next: fill in what you know of the drives, then")
    typer.echo(f"  mjfriction inspect {log or 'LOG'} --robot {out}")
