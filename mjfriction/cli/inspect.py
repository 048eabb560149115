"""``mjfriction inspect``: the contents of a log, and what it could show."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from mjfriction.cli.logs import GUESS, columns_of, guess_of, is_log, read_logs
from mjfriction.cli.options import Json, LogPath, MapSource
from mjfriction.cli.progress import telling

Robot = Annotated[
    str | None,
    typer.Option(
        "--robot",
        metavar="R",
        help="A robot.toml or a bundled robot: then also what could be found.",
        show_default=False,
    ),
]
Write = Annotated[
    Path | None,
    typer.Option("--write-map", metavar="M.toml", help="Write the guessed columns, to be looked at and kept."),
]


def inspect(
    log: LogPath, robot: Robot = None, map_: MapSource = None, write_map: Write = None, json: Json = False
) -> None:
    """Show what a log contains and whether it can be diagnosed: joints, rate, gaps, ranges, what it could show.

    Columns with other names are guessed and shown; --map guess accepts the guess, --map M.toml uses your own mapping.

    Example: mjfriction inspect run1.csv --robot ur5 --write-map columns.toml
    """
    import json as writer

    from rich.console import Console

    from mjfriction.errors import LogError
    from mjfriction.record.mapping import Mapping, template
    from mjfriction.report.folder import whole_file
    from mjfriction.report.inspected import inspected_table
    from mjfriction.report.text import WIDTH, print_inspected, print_mapping, print_unguessed
    from mjfriction.robot.files import read_robot

    model = read_robot(robot) if robot is not None else None
    joints = model.joints if model is not None else [f"joint_{i + 1}" for i in range(32)]
    console = Console(width=WIDTH, highlight=False, soft_wrap=False)
    guess: Mapping | None = guess_of(log, joints) if map_ in (None, GUESS) else None
    if write_map is not None and guess is None:
        names = columns_of(log)
        if is_log(names):
            raise LogError(f"{log}: no columns to guess: they have a log's names already")
        with whole_file(write_map) as draft:
            draft.write_text(template(names, joints if model is not None else joints[:2]), encoding="utf-8")
        if json:
            typer.echo(writer.dumps({"columns": names, "mapping": str(write_map)}, indent=2, ensure_ascii=False))
        else:
            print_unguessed(names, log, write_map, console)
        return
    if write_map is not None and guess is not None:
        with whole_file(write_map) as draft:
            draft.write_text(guess.text(), encoding="utf-8")
    if guess is not None and not json:
        print_mapping(guess, log, write_map, console)
    with telling() as tell:
        found = read_logs([log], joints, GUESS if guess is not None else map_)
        told = inspected_table(found, model, tell)
    if guess is not None:
        told["guessed_columns"] = {own: source.model_dump() for own, source in guess.sources.items()}
    if json:
        typer.echo(writer.dumps(told, indent=2, ensure_ascii=False))
        return
    print_inspected(told, console)
