"""A table written to a file, as CSV or Parquet by the file's name."""

from __future__ import annotations

from pathlib import Path

import pyarrow as pa
import pyarrow.csv
import pyarrow.parquet

from mjfriction.errors import OutputError
from mjfriction.report.folder import whole_file


def check_table_name(target: Path, what: str) -> None:
    """Raise :class:`OutputError` unless the file name ends in .csv or .parquet; ``what`` names the table's content."""
    if target.suffix.lower() not in (".csv", ".parquet"):
        raise OutputError(f"{target}: {what} is written as .csv or .parquet; name it so")


def write_table(table: pa.Table, target: Path) -> None:
    """Write a table to a file, whole or not at all."""
    with whole_file(target) as draft:
        if target.suffix.lower() == ".csv":
            pyarrow.csv.write_csv(table, draft)
        else:
            pyarrow.parquet.write_table(table, draft, compression="zstd")
