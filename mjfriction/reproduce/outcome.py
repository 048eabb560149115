"""What a reproduced experiment hands on: tables, pictures, and what came out as the document says and what did not."""

from __future__ import annotations

from dataclasses import dataclass, field

from mjfriction.laws.law import Floats


@dataclass(frozen=True)
class Row:
    """One line of a table: what it is, and its cells, numbers or words, None where there is none."""

    name: str
    cells: tuple[float | str | None, ...]


@dataclass(frozen=True)
class Table:
    """Figures beside the document's: ``columns`` name the cells of every row."""

    title: str
    columns: tuple[str, ...]
    rows: tuple[Row, ...]
    note: str = ""


@dataclass(frozen=True)
class Line:
    """One course of a picture, (n,) each; ``marks`` draws points in place of a line."""

    name: str
    x: Floats
    y: Floats
    marks: bool = False


@dataclass(frozen=True)
class Picture:
    """One picture, after the document's ``figure`` where it has such a one."""

    title: str
    across: str
    up: str
    lines: tuple[Line, ...]
    figure: str = ""
    logarithmic: bool = False


@dataclass(frozen=True)
class Claim:
    """A sentence of the document, whether it held here, and with what figures."""

    sentence: str
    holds: bool
    figures: str


@dataclass(frozen=True)
class Reproduction:
    """One document's experiments: ``how`` tells the machine and the procedure, ``differs`` where ours is another."""

    name: str
    title: str
    source: str
    how: tuple[str, ...]
    tables: tuple[Table, ...]
    pictures: tuple[Picture, ...]
    claims: tuple[Claim, ...]
    differs: tuple[str, ...] = field(default=())
