"""Logs kept as Parquet."""

from __future__ import annotations

from pathlib import Path

import pyarrow as pa
import pyarrow.parquet

from mjfriction.errors import LogError


def read_parquet_table(path: Path) -> pa.Table:
    """Read a Parquet file; :class:`LogError` when it cannot be parsed."""
    try:
        return pyarrow.parquet.read_table(path)
    except (pa.ArrowInvalid, OSError) as error:
        raise LogError(f"{path}: not a readable Parquet table: {str(error).splitlines()[0]}") from None
