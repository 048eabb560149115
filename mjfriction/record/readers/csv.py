"""Logs kept as comma-separated text."""

from __future__ import annotations

from pathlib import Path

import pyarrow as pa
import pyarrow.csv

from mjfriction.errors import LogError


def read_table(path: Path) -> pa.Table:
    """Read a CSV file with one header line; :class:`LogError` when it cannot be parsed."""
    try:
        return pyarrow.csv.read_csv(path)
    except (pa.ArrowInvalid, OSError) as error:
        raise LogError(f"{path}: not a readable CSV table: {str(error).splitlines()[0]}") from None
