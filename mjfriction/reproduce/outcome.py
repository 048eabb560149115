"""The results of a reproduced experiment: tables, pictures, and which claims of the document held."""

from __future__ import annotations

from dataclasses import dataclass, field

from mjfriction.laws.law import Floats


@dataclass(frozen=True)
class Row:
    """One line of a table: its name and its cells, which are numbers or words, None where empty."""

    name: str
    cells: tuple[float | str | None, ...]


@dataclass(frozen=True)
class Table:
    """Numbers beside the document's: ``columns`` name the cells of every row."""

    title: str
    columns: tuple[str, ...]
    rows: tuple[Row, ...]
    note: str = ""


@dataclass(frozen=True)
class Line:
    """One curve of a picture, ``x`` and ``y`` (n,); ``marks`` draws points instead of a line."""

    name: str
    x: Floats
    y: Floats
    marks: bool = False


@dataclass(frozen=True)
class Picture:
    """One picture; ``figure`` names the document's figure that it corresponds to, if any."""

    title: str
    across: str
    up: str
    lines: tuple[Line, ...]
    figure: str = ""
    logarithmic: bool = False


@dataclass(frozen=True)
class Claim:
    """A sentence of the document, whether it held here, and the numbers for it."""

    sentence: str
    holds: bool
    figures: str


@dataclass(frozen=True)
class Reproduction:
    """One document's experiments: ``how`` describes machine and procedure, ``differs`` says where ours differ."""

    name: str
    title: str
    source: str
    how: tuple[str, ...]
    tables: tuple[Table, ...]
    pictures: tuple[Picture, ...]
    claims: tuple[Claim, ...]
    differs: tuple[str, ...] = field(default=())
