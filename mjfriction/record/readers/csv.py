"""Logs kept as comma-separated text."""

from __future__ import annotations

from pathlib import Path

import pyarrow as pa
import pyarrow.csv

from mjfriction.errors import LogError


def read_table(path: Path) -> pa.Table:
    """Read a CSV file with one header line, its columns parted by commas, semicolons or tabs.

    Raises :class:`LogError` when it cannot be parsed.
    """
    try:
        with path.open("rb") as stream:
            head = stream.readline()
        mark = max((b",", b";", b"\t"), key=head.count).decode()
        options = pyarrow.csv.ParseOptions(delimiter=mark)
        decimal = pyarrow.csv.ConvertOptions(
            decimal_point="," if mark != "," and b"," in path.read_bytes()[:4096] else "."
        )
        return pyarrow.csv.read_csv(path, parse_options=options, convert_options=decimal)
    except (pa.ArrowInvalid, OSError) as error:
        raise LogError(f"{path}: not a readable CSV table: {str(error).splitlines()[0]}") from None
