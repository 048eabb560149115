"""``mjfriction predict``: what a log would have read according to a robot."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from mjfriction.cli.logs import read_logs
from mjfriction.cli.options import Json, LogPath, MapSource, RobotSource
from mjfriction.cli.progress import PREDICTED, READ, telling

if TYPE_CHECKING:
    from mjfriction.identify.gap import Gap
    from mjfriction.record.log import Log
    from mjfriction.robot.robot import Robot

Out = Annotated[
    Path, typer.Option("--out", metavar="P.parquet", help="A .parquet or .csv to write.", show_default=False)
]


def predict(log: LogPath, robot: RobotSource, out: Out, map_: MapSource = None, json: Json = False) -> None:
    """Predict what the drives would have reported along a log's motion.

    Writes time and the log's own effort or current columns as the robot file predicts them, row by row.

    Example: mjfriction predict run2.parquet --robot result/robot.toml --out predicted.parquet
    """
    import numpy as np
    import pyarrow as pa

    from mjfriction.report.table_file import check_table_name, write_table
    from mjfriction.robot.files import read_robot
    from mjfriction.robot.predict import predict_log

    check_table_name(out, "a prediction")
    with telling() as tell:
        tell("reading the log", 0.0)
        stated = read_robot(robot)
        measured = read_logs([log], stated.joints, map_)
        tell("predicting", READ)
        predicted = predict_log(measured, stated)
        tell("measuring the error in motion", PREDICTED)
        gap = _gap(measured, stated)
        write_table(pa.table(predicted), out)
    errors: dict[str, dict[str, float | None]] = {}
    for name in list(predicted)[1:]:
        reported = measured.as_recorded(measured.columns[name])
        rms, size = (float(np.sqrt(np.nanmean(np.square(v)))) for v in (reported - predicted[name], reported))
        errors[name] = {"rms_error": rms, "relative": rms / size if size else None}
        joint = stated.joints.index(name.partition(".")[2])
        if gap is not None and joint in gap.examined:
            unit = abs(float(gap.per_reported[joint]))
            errors[name] |= {
                "rms_moving": gap.rms(gap.residual[:, joint], joint) / unit,
                "noise_floor": float(gap.noise_floor[joint]) / unit,
            }
    if json:
        import json as writer

        typer.echo(writer.dumps({"out": str(out), "columns": errors}, indent=2))
        return
    for name, error in errors.items():
        share = "" if error["relative"] is None else f"  ({100 * error['relative']:.3g} % of what was measured)"
        typer.echo(f"{name}: RMS error {error['rms_error']:.4g}{share}")
        if "rms_moving" in error:
            typer.echo(f"  while it moves {error['rms_moving']:.3g}, sensor noise {error['noise_floor']:.3g}")
    if gap is not None:
        typer.echo(
            f"The first is over every sample, with rests and reversals; the second below {gap.chain.band:.3g} Hz,\n"
            "as in a report."
        )


def _gap(log: Log, robot: Robot) -> Gap | None:
    # None for a log that can be predicted but is too short to be compared with a robot.
    from mjfriction.errors import LogError
    from mjfriction.identify.measure import measure_gap

    try:
        return measure_gap(log, robot)
    except LogError:
        return None
