"""Readers of log files, one per format, chosen by the file's extension."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pyarrow as pa

from mjfriction.errors import LogError
from mjfriction.record.log import Log
from mjfriction.record.readers.csv import read_csv_table
from mjfriction.record.readers.parquet import read_parquet_table
from mjfriction.record.readers.table import log_from_table

READERS: dict[str, Callable[[Path], pa.Table]] = {".csv": read_csv_table, ".parquet": read_parquet_table}


def read_log(path: Path | str) -> Log:
    """Read a log from a CSV or Parquet file.

    Raises :class:`~mjfriction.errors.LogError`, one line saying the file, the row or column, and what to do, when the
    file is missing, cannot be parsed, or is not a log (see :func:`~mjfriction.record.readers.table.log_from_table`).
    """
    return log_from_table(read_table(Path(path)), str(path))


def read_table(path: Path) -> pa.Table:
    """Read a table from a CSV or Parquet file, whatever is in it; :class:`LogError` when it cannot be parsed."""
    if path.suffix.lower() not in READERS:
        raise LogError(f"{path}: cannot read a '{path.suffix}' file as a log; allowed are {', '.join(READERS)}")
    if not path.is_file():
        raise LogError(f"{path}: there is no such file")
    return READERS[path.suffix.lower()](path)
