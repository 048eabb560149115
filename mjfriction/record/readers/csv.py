"""Logs kept as comma-separated text."""

from __future__ import annotations

import codecs
from pathlib import Path

import pyarrow as pa
import pyarrow.csv

from mjfriction.errors import LogError

PIECE = 1 << 20  # bytes looked at in one go: a log may be larger than the memory


def read_table(path: Path) -> pa.Table:
    """Read a CSV file with one header line, its columns separated by commas, semicolons or tabs.

    Where they are not parted by commas, decimals are after a point or a comma, whichever makes numbers of more columns.

    Raises :class:`LogError` when it cannot be parsed.
    """
    try:
        with path.open("rb") as stream:
            head = stream.readline()
        encoding = _encoding(path, head)
        text = head.decode(encoding, errors="replace")
        mark = max(",;\t", key=text.count)
        tables = [_read(path, encoding, mark, point) for point in ("." if mark == "," else ".,")]
        return max(tables, key=_numeric)
    except (pa.ArrowInvalid, UnicodeError, OSError) as error:
        raise LogError(f"{path}: not a readable CSV table: {str(error).splitlines()[0]}") from None


def _encoding(path: Path, head: bytes) -> str:
    # UTF-8, unless a mark says UTF-16 or the bytes are none of it: then what spreadsheets of the West write.
    if head.startswith((b"\xff\xfe", b"\xfe\xff")):
        return "utf-16"
    decoder = codecs.getincrementaldecoder("utf-8")()
    try:
        with path.open("rb") as stream:
            while piece := stream.read(PIECE):
                decoder.decode(piece)
        decoder.decode(b"", final=True)
    except UnicodeDecodeError:
        return "latin-1"
    return "utf-8"


def _read(path: Path, encoding: str, mark: str, decimal_point: str) -> pa.Table:
    return pyarrow.csv.read_csv(
        path,
        read_options=pyarrow.csv.ReadOptions(encoding=encoding),
        parse_options=pyarrow.csv.ParseOptions(delimiter=mark),
        convert_options=pyarrow.csv.ConvertOptions(decimal_point=decimal_point),
    )


def _numeric(table: pa.Table) -> int:
    return sum(pa.types.is_floating(column.type) or pa.types.is_integer(column.type) for column in table.columns)
