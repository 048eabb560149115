"""Readers of log files, one per format, chosen by the file's extension."""

from __future__ import annotations

import importlib
from collections import Counter
from pathlib import Path

import pyarrow as pa

from mjfriction.errors import LogError
from mjfriction.record.log import Log
from mjfriction.record.mapping import Mapping
from mjfriction.record.readers.table import log_from_table

READERS = {
    ".csv": "csv",
    ".parquet": "parquet",
    ".npz": "npz",
    ".mat": "matlab",
    ".h5": "hdf5",
    ".hdf5": "hdf5",
    ".mcap": "mcap",
}
"""The module that reads each kind of file by its ``read_table``; loaded when it is asked for."""


def read_log(path: Path | str, mapping: Mapping | None = None) -> Log:
    """Read a log from a CSV, Parquet, NumPy, MATLAB, HDF5 or MCAP file, or from the folder of a ROS 2 bag.

    ``mapping`` maps the file's columns to a log's, where the file names them differently.  Raises
    :class:`~mjfriction.errors.LogError`, one line that states the file, the row or column, and what to do, when the
    file is missing, cannot be parsed, or is not a log (see
    :func:`~mjfriction.record.readers.table.log_from_table`).
    """
    table = read_table(Path(path))
    return log_from_table(mapping.applied(table, str(path)) if mapping is not None else table, str(path))


def read_table(path: Path) -> pa.Table:
    """Read a table from a file of any supported kind, its columns' names without blanks around them.

    Raises :class:`LogError` when it cannot be parsed, or has two columns of one name.
    """
    if path.is_dir():
        kind = "mcap"
    elif path.suffix.lower() not in READERS:
        raise LogError(f"{path}: cannot read a '{path.suffix}' file as a log; allowed are {', '.join(READERS)}")
    elif not path.is_file():
        raise LogError(f"{path}: there is no such file")
    else:
        kind = READERS[path.suffix.lower()]
    table = importlib.import_module(f"{__name__}.{kind}").read_table(path)
    assert isinstance(table, pa.Table)
    names = [name.strip() for name in table.schema.names]
    twice = [name for name, count in Counter(names).items() if count > 1]
    if twice:
        raise LogError(
            f"{path}: column '{twice[0]}' is there {names.count(twice[0])} times; rename or delete all but one"
        )
    return table.rename_columns(names)
