"""``mjfriction observe``: friction along a log, as estimated by an observer."""

from __future__ import annotations

import enum
from pathlib import Path
from typing import Annotated

import typer

from mjfriction.cli.logs import read_logs
from mjfriction.cli.options import Json, LogPath, MapSource, RobotSource
from mjfriction.cli.progress import READ, telling

Out = Annotated[Path, typer.Option("--out", metavar="T", help="Table to write, .csv or .parquet.", show_default=False)]


class Kind(enum.Enum):
    """The available observers."""

    BALANCE = "balance"
    DISTURBANCE = "disturbance"
    FRIEDLAND_PARK = "friedland_park"
    FRIEDLAND_MENTZELOPOULOU = "friedland_mentzelopoulou"
    TAFAZOLI = "tafazoli"
    VARIABLE_STRUCTURE = "variable_structure"
    BRISTLE = "bristle"


def observe(
    log: LogPath,
    robot: RobotSource,
    out: Out,
    observer: Annotated[Kind, typer.Option(help="Which observer.")] = Kind.BALANCE,
    bandwidth: Annotated[float, typer.Option(help="How fast its errors die away, Hz.", min=0.01, max=1000.0)] = 10.0,
    map_: MapSource = None,
    json: Json = False,
) -> None:
    """Estimate the friction of every joint along a log, without a friction law: as the remainder of the balance of
    efforts, or by an observer that runs live (bristle uses the joint's law).

    The rest of the robot file is taken as true. Writes time, friction.<joint> and velocity.<joint>, row by row.

    Example: mjfriction observe run.parquet --robot ur5 --observer disturbance --out friction.parquet
    """
    import numpy as np
    import pyarrow as pa

    from mjfriction.control.observe import observe_log
    from mjfriction.record.log import EFFORT
    from mjfriction.report.table_file import check_table_name, write_table
    from mjfriction.robot.effort import reported_unit
    from mjfriction.robot.files import read_robot

    check_table_name(out, "what was observed")
    with telling() as tell:
        tell("reading the log", 0.0)
        stated = read_robot(robot)
        measured = read_logs([log], stated.joints, map_)
        tell("observing", READ)
        found = observe_log(measured, stated, observer.value, bandwidth)
        write_table(pa.table(found), out)
    sizes = {
        name.removeprefix("friction."): {
            "rms": float(np.sqrt(np.nanmean(np.square(values)))),
            "largest": float(np.nanmax(np.abs(values))),
        }
        for name, values in found.items()
        if name.startswith("friction.")
    }
    if json:
        import json as writer

        typer.echo(writer.dumps({"out": str(out), "friction": sizes}, indent=2))
        return
    sliding = stated.body().sliding
    for name, size in sizes.items():
        unit = reported_unit(EFFORT, sliding[stated.joints.index(name)])
        typer.echo(f"{name}: friction RMS {size['rms']:.4g} {unit}, at most {size['largest']:.4g} {unit}")
