"""``mjfriction simulate``: a robot file in place of the real machine."""

from __future__ import annotations

import enum
from pathlib import Path
from typing import Annotated

import typer

from mjfriction.cli.options import RobotSource
from mjfriction.cli.progress import telling

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
Recording = Annotated[
    Path | None,
    typer.Option(
        "--recording", metavar="R.rrd", help="Also record the machine in motion, for Rerun.", show_default=False
    ),
]


class Feedforward(enum.Enum):
    """The part of its model that the controller feeds forward."""

    DYNAMICS = "dynamics"
    GRAVITY = "gravity"
    NONE = "none"


class Compensation(enum.Enum):
    """The part of its model's friction that the controller feeds forward."""

    COULOMB_VISCOUS = "coulomb_viscous"
    LAW = "law"
    NONE = "none"


def simulate(
    robot: RobotSource,
    trajectory: TrajectorySource,
    out: Out,
    controller: Model = None,
    rate: Annotated[float, typer.Option(help="Samples per second.", min=10.0, max=20000.0)] = 1000.0,
    jitter: Annotated[float, typer.Option(help="Spread of the instants, share of a step.", min=0.0, max=0.45)] = 0.0,
    current: Annotated[bool, typer.Option("--current", help="Log motor currents in place of efforts.")] = False,
    velocity: Annotated[bool, typer.Option("--velocity", help="Log measured velocities too.")] = False,
    bandwidth: Annotated[float, typer.Option(help="Of the joints' control, Hz.", min=0.1, max=200.0)] = 4.0,
    feedforward: Annotated[
        Feedforward, typer.Option(help="What of its model the controller adds.")
    ] = Feedforward.DYNAMICS,
    friction: Annotated[
        Compensation, typer.Option(help="Its friction fed forward: stated levels, its laws, or none.")
    ] = Compensation.COULOMB_VISCOUS,
    observer: Annotated[
        float | None, typer.Option(metavar="HZ", help="Observe the rest of friction and give it back.", min=0.01)
    ] = None,
    sensed: Annotated[bool, typer.Option("--sensed", help="Let it read the sensors, not the truth.")] = False,
    recording: Recording = None,
    seed: Annotated[int, typer.Option(help="Sets the sensors' noise.", min=0)] = 0,
) -> None:
    """Run a robot along a trajectory in closed loop and write a log: everything its file states acts in MuJoCo.

    Example: mjfriction simulate --robot ur5 --trajectory motion.csv --out run.parquet --rate 500
    """
    import pyarrow

    from mjfriction.control.disturbance import disturbance_observer
    from mjfriction.control.servo import Control
    from mjfriction.plant.machine import log_columns, not_followed, run_machine
    from mjfriction.plant.sensors import Recorder
    from mjfriction.plant.trajectory import read_trajectory
    from mjfriction.record.log import CURRENT, EFFORT
    from mjfriction.report.folder import whole_file
    from mjfriction.report.table_file import check_table_name, write_table
    from mjfriction.robot.files import read_robot

    check_table_name(out, "a log")
    with telling() as tell:
        machine, course = read_robot(robot), read_trajectory(trajectory)
        recorder = Recorder(rate, jitter, velocity, CURRENT if current else EFFORT)
        run = run_machine(
            machine,
            course,
            rate,
            Control(
                bandwidth=bandwidth,
                feedforward=feedforward.value,
                friction=friction.value,
                observer=None if observer is None else disturbance_observer(observer),
                sensed=sensed,
                seed=seed,
            ),
            read_robot(controller) if controller else None,
            whole=recording is not None,
            tell=tell,
        )
        table = pyarrow.table(log_columns(machine, course, recorder, run, seed))
    if recording is None:
        write_table(table, out)
    else:
        from mjfriction.report.run_view import write_run

        with telling() as tell, whole_file(recording) as draft:
            tell("drawing")
            write_run(machine, run, draft)
            write_table(table, out)  # a log that cannot be written leaves no recording either
    lost = not_followed(machine, run)
    hint = ["try more with --bandwidth; friction holds what a weak controller asks for"] if lost else []
    for note in (*run.notes, *lost, *hint):
        typer.echo(note, err=True)
    seconds = float(run.time[-1] - run.time[0])
    typer.echo(f"{out}: {table.num_rows} rows, {seconds:.4g} s of {table.num_columns} columns")
    if recording is not None:
        typer.echo(f"{recording}: open it with mjfriction view {recording}")
