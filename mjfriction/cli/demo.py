"""``mjfriction demo``: the main job on bundled input."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from mjfriction.cli.options import Json

Out = Annotated[Path, typer.Option("--out", metavar="DIR", help="Folder for the results.")]


def demo(out: Out = Path("demo_out"), json: Json = False) -> None:
    """Diagnose a bundled log of a simulated arm with something hidden in it, and prove the result on a second log.

    Example: mjfriction demo --out demo_out
    """
    from importlib.resources import files

    from mjfriction.cli.diagnose import report_diagnosis

    bundled = Path(str(files("mjfriction"))) / "bundled" / "demo"
    robot = bundled / "robot.toml"
    if not json:
        typer.echo("A simulated UR5 was recorded for 30 s. Its elbow hides something that its robot file does not state.\n")
    report_diagnosis([bundled / "log.parquet"], str(robot), out, seed=0, json=json)
    if json:
        return
    before, after = (_errors(bundled / "other_motion.parquet", path) for path in (robot, out / "robot.toml"))
    typer.echo("\nThe proof, on a second log of the same arm along another motion (RMS error, N·m):")
    for joint, error in before.items():
        typer.echo(f"  {joint:22s} stated {error:7.3f}   extended {after[joint]:7.3f}")


def _errors(log: Path, robot: Path) -> dict[str, float]:
    import numpy as np

    from mjfriction.record.readers import read_log
    from mjfriction.robot.files import read_robot
    from mjfriction.robot.predict import predict_log

    measured = read_log(log)
    predicted = predict_log(measured, read_robot(robot))
    return {
        name.partition(".")[2]: float(np.sqrt(np.nanmean(np.square(measured.columns[name] - values))))
        for name, values in predicted.items()
        if name != "time"
    }
