"""``mjfriction plan``: the experiment to run next."""

from __future__ import annotations

import enum
from pathlib import Path
from typing import Annotated

import typer

from mjfriction.cli.options import RobotSource
from mjfriction.cli.progress import telling


class Protocol(enum.Enum):
    """The available experiments."""

    FORWARD_BACKWARD = "forward_backward"
    EXCITATION = "excitation"
    SEPARATE = "separate"
    SINE = "sine"
    SAWTOOTH = "sawtooth"
    LOOPS = "loops"
    PICK_AND_PLACE = "pick_and_place"
    VOLTAGES = "voltages"


ONE_BY_ONE = (Protocol.FORWARD_BACKWARD, Protocol.SINE, Protocol.SAWTOOTH, Protocol.LOOPS, Protocol.VOLTAGES)
OF_PROTOCOL = {
    "--joint": ONE_BY_ONE,
    "--speeds": (Protocol.FORWARD_BACKWARD,),
    "--slowest": (Protocol.FORWARD_BACKWARD,),
    "--fastest": (Protocol.FORWARD_BACKWARD,),
    "--stroke": (Protocol.FORWARD_BACKWARD,),
    "--seconds": (Protocol.EXCITATION,),
    "--amplitude": (Protocol.SAWTOOTH, Protocol.LOOPS),
    "--against": (Protocol.SEPARATE,),
}

Kind = Annotated[Protocol, typer.Option("--protocol", help="What the motion is to show.", show_default=False)]
Out = Annotated[
    Path, typer.Option("--out", metavar="T", help="Trajectory table, .csv or .parquet.", show_default=False)
]
Joints = Annotated[
    list[str] | None,
    typer.Option("--joint", metavar="J", help="A joint to move alone; repeat for more. All by default."),
]
Other = Annotated[str | None, typer.Option("--against", metavar="R", help="The other model of the robot (separate).")]


def plan(
    robot: RobotSource,
    protocol: Kind,
    out: Out,
    joint: Joints = None,
    speeds: Annotated[int | None, typer.Option(help="How many speeds a joint (forward_backward): 12.", min=3)] = None,
    slowest: Annotated[float | None, typer.Option(help="Slowest, rad/s or m/s (forward_backward).", min=1e-9)] = None,
    fastest: Annotated[float | None, typer.Option(help="Fastest, rad/s or m/s (forward_backward).", min=1e-9)] = None,
    stroke: Annotated[float | None, typer.Option(help="How far, rad or m (forward_backward).", min=1e-9)] = None,
    seconds: Annotated[float | None, typer.Option(help="How long (excitation): 60 s.", min=10.0)] = None,
    amplitude: Annotated[float | None, typer.Option(help="Largest turn, rad or m (sawtooth, loops).", min=1e-9)] = None,
    against: Other = None,
    seed: Annotated[int, typer.Option(help="Sets what is drawn.")] = 0,
) -> None:
    """Write the motion to record next, within the joints' limits, as a table of time and positions.

    forward_backward: each joint to and fro at many speeds, where gravity loads it least, for its friction map.
    excitation: all joints at once, to separate links from friction. separate: where two models of one robot differ
    most. sine, sawtooth, loops: one joint slowly, for friction near rest. pick_and_place: as at work. voltages: steps
    of a valve's voltage.

    Example: mjfriction plan --robot ur5 --protocol forward_backward --joint elbow_joint --out passes.csv
    """
    from mjfriction.errors import RobotError
    from mjfriction.identify.protocol import (
        USUAL_SECONDS,
        USUAL_SPEEDS,
        plan_excitation,
        plan_passes,
        plan_separation,
    )
    from mjfriction.identify.usual_motions import (
        plan_loops,
        plan_pick_and_place,
        plan_sawtooth,
        plan_sine,
        plan_voltages,
    )
    from mjfriction.report.table_file import check_table_name, write_table
    from mjfriction.robot.files import read_robot

    check_table_name(out, "a trajectory")
    given = {"--joint": joint, "--speeds": speeds, "--seconds": seconds, "--amplitude": amplitude, "--against": against}
    given |= {"--slowest": slowest, "--fastest": fastest, "--stroke": stroke}
    for name, value in given.items():
        if value is not None and protocol not in OF_PROTOCOL[name]:
            listed = " or ".join(f"'{one.value}'" for one in OF_PROTOCOL[name])
            raise RobotError(f"{name} is of the protocol {listed}; leave it out, or ask for that one")
    with telling() as tell:
        model = read_robot(robot)
        joints = joint or model.joints
        if protocol is Protocol.FORWARD_BACKWARD:
            found = plan_passes(
                model,
                joints,
                count=speeds or USUAL_SPEEDS,
                slowest=slowest,
                fastest=fastest,
                stroke=stroke,
                seed=seed,
                tell=tell,
            )
        elif protocol is Protocol.SINE:
            found = plan_sine(model, joints)
        elif protocol is Protocol.SAWTOOTH:
            found = plan_sawtooth(model, joints, amplitude)
        elif protocol is Protocol.LOOPS:
            found = plan_loops(model, joints, amplitude)
        elif protocol is Protocol.PICK_AND_PLACE:
            found = plan_pick_and_place(model, seed=seed)
        elif protocol is Protocol.VOLTAGES:
            found = plan_voltages(model, joints)
        elif protocol is Protocol.EXCITATION:
            found = plan_excitation(model, seconds or USUAL_SECONDS, seed=seed, tell=tell)
        elif against is None:
            raise RobotError("the protocol 'separate' needs the other model of the robot: give it with --against")
        else:
            found = plan_separation((model, read_robot(against)), seed=seed, tell=tell)
        write_table(found.trajectory.table(), out)
    typer.echo(f"{out}: {float(found.trajectory.time[-1]):.4g} s")
    for line in found.words:
        typer.echo(f"  {line}")
    typer.echo("Collisions are not checked: look at it simulated before a machine runs it.")
