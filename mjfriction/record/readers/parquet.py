"""Logs kept as Parquet, including LeRobot datasets."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet

from mjfriction.errors import LogError
from mjfriction.record.log import EFFORT, POSITION, VELOCITY
from mjfriction.record.readers.arrays import table_of

STATE = "observation.state"
LEROBOT = {STATE: POSITION, "observation.velocity": VELOCITY, "observation.effort": EFFORT}


def read_table(path: Path) -> pa.Table:
    """Read a Parquet file; :class:`LogError` when it cannot be parsed.

    A LeRobot dataset's episodes become segments, and its states become positions, named as in its ``meta/info.json``.
    """
    try:
        table = pyarrow.parquet.read_table(path)
    except (pa.ArrowInvalid, OSError) as error:
        raise LogError(f"{path}: not a readable Parquet table: {str(error).splitlines()[0]}") from None
    return _from_lerobot(table, path) if {STATE, "timestamp"} <= set(table.schema.names) else table


def _from_lerobot(table: pa.Table, path: Path) -> pa.Table:
    arrays = {"time": table["timestamp"].to_numpy()}
    try:
        arrays |= {
            own: np.vstack(table[name].to_pylist()) for name, own in LEROBOT.items() if name in table.schema.names
        }
    except (ValueError, TypeError):
        raise LogError(f"{path}: not every row has a state of every joint; drop the rows that have none") from None
    if "episode_index" in table.schema.names:
        arrays["segment"] = table["episode_index"].to_numpy()
    return table_of(arrays, _state_names(path), str(path))


def _state_names(path: Path) -> list[str] | None:
    for folder in path.resolve().parents:
        info = folder / "meta" / "info.json"
        if info.is_file():
            try:
                named = json.loads(info.read_text(encoding="utf-8")).get("features", {}).get(STATE, {}).get("names")
            except (ValueError, AttributeError):
                raise LogError(f"{info}: cannot be read as a LeRobot dataset's info") from None
            if isinstance(named, dict):  # {"motors": [...]} in older datasets
                named = next(iter(named.values()), None)
            if isinstance(named, list):
                return [str(name).removesuffix(".pos") for name in named]
    return None
