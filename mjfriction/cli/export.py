"""``mjfriction export``: a robot as plain MJCF for stock MuJoCo."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from mjfriction.cli.options import Json, RobotSource

Out = Annotated[Path, typer.Option("--out", metavar="MODEL.xml", help="The file to write.", show_default=False)]
Fastest = Annotated[
    float, typer.Option("--fastest", help="Highest joint speed the friction must be right for, rad/s or m/s.", min=1e-6)
]


def export(robot: RobotSource, out: Out, fastest: Fastest = 2.0, as_json: Json = False) -> None:
    """Write a robot as plain MJCF that runs in stock MuJoCo with no callback, and list what MJCF cannot express.

    Example: mjfriction export --robot ur5 --out ur5.xml
    """
    import json
    from dataclasses import asdict

    from mjfriction.errors import OutputError, RobotError
    from mjfriction.report.folder import whole_file
    from mjfriction.robot.files import read_robot
    from mjfriction.robot.simulation import not_in_model, robot_laws, robot_spec
    from mjfriction.sim.export import export_spec

    read = read_robot(robot)
    if out.suffix.lower() != ".xml":
        raise OutputError(f"{out}: what is written is MJCF; give a name that ends in .xml")
    if not out.parent.is_dir() or out.is_dir():
        raise OutputError(f"{out}: give the name of a file in a folder that is there")
    try:
        spec, carried = export_spec(robot_spec(read), robot_laws(read), fastest=fastest)
        spec.compile()
    except ValueError as error:
        raise RobotError(f"{read.model_path}: MuJoCo cannot compile it: {' '.join(str(error).split())}") from None
    with whole_file(out) as draft:
        draft.write_text(spec.to_xml(), encoding="utf-8")
    lost = {joint.name: keys for joint in read.table.joint if (keys := not_in_model(joint))}
    of_robot = ["taken_up"] if read.table.taken_up else []
    if as_json:
        typer.echo(
            json.dumps(
                {
                    "model": str(out),
                    "joints": [asdict(one) for one in carried],
                    "not_carried": lost,
                    "not_carried_of_robot": of_robot,
                }
            )
        )
        return
    for one in carried:
        how = "exact" if one.exact else f"fit, off by {one.error:.3g} of {one.size:.3g} {one.unit} (RMS)"
        typer.echo(f"{one.joint}: {one.element}; {how}")
    alike: dict[str, list[str]] = {}
    for name, keys in lost.items():
        alike.setdefault(", ".join(keys), []).append(name)
    for listed, names in alike.items():
        typer.echo(f"not in the model: {listed} of {', '.join(names)}")
    if of_robot:
        typer.echo(f"not in the model: {', '.join(of_robot)} of the robot")
    typer.echo(f"written: {out}")
