"""``mjfriction predict``: what a robot says a log would have read."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from mjfriction.cli.logs import read_logs
from mjfriction.cli.options import Json, LogPath, MapSource, RobotSource
from mjfriction.cli.progress import READ, telling

Out = Annotated[
    Path, typer.Option("--out", metavar="P.parquet", help="A .parquet or .csv to write.", show_default=False)
]


def predict(log: LogPath, robot: RobotSource, out: Out, map_: MapSource = None, json: Json = False) -> None:
    """Predict what the drives would have reported along a log's motion.

    Writes time and the log's own effort or current columns as the robot says they would read, row by row.

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
        write_table(pa.table(predicted), out)
    errors = {}
    for name in list(predicted)[1:]:
        reported = measured.as_recorded(measured.columns[name])
        rms, size = (float(np.sqrt(np.nanmean(np.square(v)))) for v in (reported - predicted[name], reported))
        errors[name] = {"rms_error": rms, "relative": rms / size if size else None}
    if json:
        import json as writer

        typer.echo(writer.dumps({"out": str(out), "columns": errors}, indent=2))
        return
    for name, error in errors.items():
        share = "" if error["relative"] is None else f"  ({100 * error['relative']:.3g} % of what was measured)"
        typer.echo(f"{name}: RMS error {error['rms_error']:.4g}{share}")
    typer.echo(
        "This is over every sample, with rests, reversals and the sensors' noise;\n"
        "mjfriction compare tells the error while a joint moves, beside the noise."
    )
