"""``mjfriction reproduce``: the source documents' experiments, with our results beside the printed ones."""

from __future__ import annotations

import enum
from functools import partial
from pathlib import Path
from typing import Annotated

import typer

from mjfriction.cli.options import Json
from mjfriction.cli.progress import telling
from mjfriction.cli.show import show


class Document(enum.Enum):
    """The available documents."""

    TABLE = "table"
    HYDRAULIC = "hydraulic"
    MANIPULATOR = "manipulator"
    ALL = "all"


What = Annotated[Document, typer.Argument(help="Whose experiments to run.", show_default=False)]
Out = Annotated[
    Path, typer.Option("--out", metavar="DIR", help="Folder for the page and its figures.", show_default=False)
]


def reproduce(
    document: What,
    out: Out,
    jobs: Annotated[int, typer.Option(help="Processes (all).", min=1, max=3)] = 2,
    seed: Annotated[int, typer.Option(help="Sets the sensors' noise.", min=0)] = 0,
    json: Json = False,
) -> None:
    """Run the experiments of the documents that the friction laws and observers come from, on simulated machines.

    table: pre-sliding compensation on a machine-tool table. hydraulic: a cylinder's friction identified, observed and
    compensated. manipulator: friction of two industrial arms and the currents it takes. Each takes some minutes.

    Example: mjfriction reproduce table --out reproduced
    """
    from mjfriction.report.folder import whole_folder
    from mjfriction.report.reproduced import reproduced_table, write_reproduced
    from mjfriction.report.text import print_reproduced
    from mjfriction.reproduce.catalog import DOCUMENTS
    from mjfriction.reproduce.catalog import reproduce as run

    names = DOCUMENTS if document is Document.ALL else (document.value,)
    with whole_folder(out) as folder, telling() as tell:
        found = run(names, tell, seed=seed, jobs=jobs)
        write_reproduced(found, folder)
    if json:
        import json as writer

        typer.echo(writer.dumps(reproduced_table(found), indent=2, ensure_ascii=False))
        return
    show(partial(print_reproduced, found), out, recorded=False)
