"""``mjfriction laws``: the available friction laws."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from mjfriction.laws.law import Law

Name = Annotated[str | None, typer.Argument(metavar="[LAW]", help="One law, to see it in full.", show_default=False)]
Out = Annotated[Path | None, typer.Option("--out", metavar="PAGE.html", help="Write the law's picture as a page.")]


def laws(name: Name = None, out: Out = None) -> None:
    """List the friction laws, or show one: formula, parameters, what it captures and misses, its picture.

    Example: mjfriction laws lugre --out lugre.html
    """
    from mjfriction.errors import InputError
    from mjfriction.laws.catalog import LAWS, find_law

    if name is None:
        if out is not None:
            raise InputError("--out writes the picture of one law; name it: mjfriction laws lugre --out lugre.html")
        _list(LAWS.values())
        return
    law = find_law(name)
    from mjfriction.report.law_page import describe, write_law_page

    typer.echo(describe(law))
    if out is not None:
        if not out.parent.is_dir():
            raise InputError(f"{out}: there is no folder {out.parent}; make it first")
        write_law_page(law, out)
        typer.echo(f"\nThe picture: {out}")


def _list(found: Iterable[Law]) -> None:
    from rich.console import Console
    from rich.table import Table

    table = Table(box=None, padding=(0, 2, 0, 0), show_header=False)
    table.add_column(no_wrap=True, style="bold")
    table.add_column()
    for law in found:
        table.add_row(law.name, law.summary)
    Console().print(table)
