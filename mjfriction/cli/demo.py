"""``mjfriction demo``: a diagnosis of bundled input."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from mjfriction.cli.options import Json

Out = Annotated[Path, typer.Option("--out", metavar="DIR", help="Folder for the results.")]


def demo(out: Out = Path("demo_out"), json: Json = False) -> None:
    """Diagnose a bundled log of a simulated arm with a hidden effect, and prove the result on a second log.

    Example: mjfriction demo --out demo_out
    """
    import shutil
    from importlib.resources import files

    from mjfriction.cli.diagnose import report_diagnosis
    from mjfriction.identify.measure import measure_gap
    from mjfriction.record.readers import read_log
    from mjfriction.report.folder import whole_file
    from mjfriction.robot.files import read_robot

    bundled = Path(str(files("mjfriction"))) / "bundled" / "demo"
    robot = "ur5"
    if not json:
        typer.echo(
            "A simulated UR5 was recorded for 30 s. Its elbow hides something that its robot file does not state.\n"
        )
    report_diagnosis([bundled / "log.parquet"], robot, out, mapping=None, seed=0, json=json)
    with whole_file(out / "log.parquet") as draft:  # so that it can be diagnosed again
        shutil.copyfile(bundled / "log.parquet", draft)
    if json:
        return
    stated, extended = (
        measure_gap(read_log(bundled / "other_motion.parquet"), read_robot(path))
        for path in (robot, str(out / "robot.toml"))
    )
    typer.echo("\nThe proof, on a second log of the same arm along another motion (RMS error, N·m):")
    for i, joint in enumerate(stated.robot.joints):
        before, after = (gap.rms(gap.residual[:, i], i) for gap in (stated, extended))
        typer.echo(f"  {joint:22s} stated {before:6.3f}   extended {after:6.3f}   noise {stated.noise_floor[i]:6.3f}")
