"""``mjfriction simulate``: a robot file plays the machine."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from mjfriction.cli.options import RobotSource
from mjfriction.cli.progress import working

TrajectorySource = Annotated[
    Path,
    typer.Option(
        "--trajectory", metavar="T", help="Table of time and position.<joint>; a log will do.", show_default=False
    ),
]
Out = Annotated[Path, typer.Option("--out", metavar="LOG", help="Where to write the log.", show_default=False)]
Model = Annotated[
    str | None,
    typer.Option(
        "--controller", metavar="R", help="The robot file that the controller computes with.", show_default=False
    ),
]


def simulate(
    robot: RobotSource,
    trajectory: TrajectorySource,
    out: Out,
    controller: Model = None,
    rate: Annotated[float, typer.Option(help="Samples per second.", min=10.0, max=20000.0)] = 1000.0,
    jitter: Annotated[float, typer.Option(help="Spread of the instants, share of a step.", min=0.0, max=0.45)] = 0.0,
    current: Annotated[bool, typer.Option("--current", help="Log motor currents in place of efforts.")] = False,
    velocity: Annotated[bool, typer.Option("--velocity", help="Log measured velocities too.")] = False,
    seed: Annotated[int, typer.Option(help="Sets the sensors' noise.")] = 0,
) -> None:
    """Run a robot along a trajectory in closed loop and write a log: everything its file states acts in MuJoCo.

    Example: mjfriction simulate --robot ur5 --trajectory motion.csv --out run.parquet --rate 500
    """
    import pyarrow

    from mjfriction.plant.machine import simulate as run
    from mjfriction.plant.sensors import Recorder
    from mjfriction.plant.trajectory import read_trajectory
    from mjfriction.record.log import CURRENT, EFFORT
    from mjfriction.report.table_file import check_table_name, write_table
    from mjfriction.robot.files import read_robot

    check_table_name(out, "a log")
    with working("simulating"):
        columns = run(
            read_robot(robot),
            read_trajectory(trajectory),
            recorder=Recorder(rate, jitter, velocity, CURRENT if current else EFFORT),
            controller_robot=read_robot(controller) if controller else None,
            seed=seed,
        )
    table = pyarrow.table(columns)
    write_table(table, out)
    typer.echo(f"{out}: {table.num_rows} rows, {float(columns['time'][-1]):.4g} s of {len(columns)} columns")
