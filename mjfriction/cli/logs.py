"""Logs given on the command line: files of any format, and a mapping of their columns."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import pyarrow as pa

    from mjfriction.record.log import Log
    from mjfriction.record.mapping import Mapping
    from mjfriction.robot.robot import Robot

GUESS = "guess"


def read_logs(paths: Sequence[Path], joints: Sequence[str], mapping: str | None, held: Sequence[float] = ()) -> Log:
    """Read logs of one robot and join them.

    ``mapping`` is a mapping file, or ``guess`` to guess from the columns' names.  ``held`` is the mass (kg) that the
    robot held during each log; it is empty if the robot held none or the logs have a column for it.

    Raises :class:`~mjfriction.errors.LogError`; where columns that a log lacks can be guessed, the message shows them.
    """
    from mjfriction.errors import LogError
    from mjfriction.record.merge import merge_logs
    from mjfriction.record.readers import read_log

    try:
        logs = [read_log(path, _mapping(path, joints, mapping)) for path in paths]
        if held:
            logs = [log.holding(mass) for log, mass in zip(logs, held, strict=True)]
        return merge_logs(logs)
    except LogError as error:
        guessed = guess_of(paths[0], joints) if mapping is None else None
        if guessed is None:
            raise
        shown = ", ".join(f"{own} from '{source.column}'" for own, source in list(guessed.sources.items())[:4])
        more = ", …" if len(guessed.sources) > 4 else ""
        raise LogError(
            f"{error} Its columns look like {shown}{more}: look at all with mjfriction inspect {paths[0]} --robot R, "
            "and take them with --map guess"
        ) from None


def held_masses(held: Sequence[float] | None, paths: Sequence[Path], robot: Robot) -> Sequence[float]:
    """Return the masses (kg) held during each log, as given by ``--held``; none where it was not given.

    Raises :class:`~mjfriction.errors.InputError` if there is not one mass for each log, a mass is impossible, or the
    robot does not state where it holds them.
    """
    from mjfriction.errors import InputError

    if not held:
        return ()
    if len(held) != len(paths):
        raise InputError(f"--held is given {len(held)} times for {len(paths)} logs; give the mass held during each")
    impossible = [mass for mass in held if not (math.isfinite(mass) and mass >= 0.0)]
    if impossible:
        raise InputError(f"--held {impossible[0]:g}: a mass is 0 kg or more")
    if robot.table.held is None:
        raise InputError(
            f"--held: robot '{robot.name}' does not say where it holds a mass; add held = {{ com = [0.0, 0.0, 0.1], "
            'parent = "link" } to its file, com in m from that link'
        )
    return held


def guess_of(path: Path, joints: Sequence[str]) -> Mapping | None:
    """Return the mapping guessed from a file's column names.

    None if the file cannot be read or needs no guess, or if time or all positions are missing from the guess.
    """
    from mjfriction.errors import LogError
    from mjfriction.record.log import POSITION
    from mjfriction.record.mapping import TIME, clocked, guess_mapping
    from mjfriction.record.readers import read_table

    try:
        table = read_table(path)
    except LogError:
        return None
    names = _names(table)
    if is_log(names):
        return None
    guess = clocked(guess_mapping(names, joints), table.rename_columns(names))
    complete = TIME in guess.sources and any(name.startswith(f"{POSITION}.") for name in guess.sources)
    return guess if complete else None


def columns_of(path: Path) -> list[str]:
    """Return the names of a file's columns; :class:`~mjfriction.errors.LogError` where it cannot be read."""
    from mjfriction.record.readers import read_table

    return _names(read_table(path))


def _names(table: pa.Table) -> list[str]:
    return [name.strip() for name in table.schema.names]


def is_log(names: Sequence[str]) -> bool:
    """Return whether columns of these names are a log's without a mapping."""
    from mjfriction.record.log import POSITION
    from mjfriction.record.mapping import TIME

    return TIME in names and any(name.startswith(f"{POSITION}.") for name in names)


def _mapping(path: Path, joints: Sequence[str], mapping: str | None) -> Mapping | None:
    from mjfriction.record.mapping import read_mapping

    if mapping is None:
        return None
    return guess_of(path, joints) if mapping == GUESS else read_mapping(Path(mapping))
