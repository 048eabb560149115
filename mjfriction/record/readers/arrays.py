"""From named arrays, as NumPy, MATLAB and HDF5 files hold them, to a table."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import pyarrow as pa

from mjfriction.errors import LogError
from mjfriction.record.log import KNOWN

JOINT_NAMES = ("joint_names", "joints", "names")


def table_of(arrays: Mapping[str, np.ndarray], names: Sequence[str] | None, source: str) -> pa.Table:
    """Return the table of arrays: a vector gives one column, a quantity (n, joints) such as ``position`` one per joint.

    ``names`` are the joints' names, in the order of the columns; ``joint_1``, ``joint_2``, … where there are none.
    A matrix of any other name, such as ``q``, gives ``q_1``, ``q_2``, …, which a mapping can then refer to.
    Arrays of another length than that of ``time`` (or, without it, of the longest) are left out.  Raises
    :class:`LogError` where there is no numeric array at all, or a matrix does not have one column per name.
    """
    vectors = {name: _plain(np.asarray(values), name) for name, values in arrays.items()}
    vectors = {name: values for name, values in vectors.items() if values.ndim and values.dtype.kind in "iuf"}
    if not vectors:
        raise LogError(f"{source}: there is no array of numbers in the file")
    rows = len(vectors["time"]) if "time" in vectors else max(max(values.shape) for values in vectors.values())
    columns: dict[str, np.ndarray] = {}
    for name, values in vectors.items():
        if values.ndim == 1 and values.size == rows:
            columns[name] = values
        elif values.ndim == 2 and name in KNOWN:
            columns |= _of_matrix(name, values, rows, names, source)
        elif values.ndim == 2 and rows in values.shape:
            tall = values if values.shape[0] == rows else values.T
            columns |= {f"{name}_{i + 1}": np.ascontiguousarray(tall[:, i]) for i in range(tall.shape[1])}
    return pa.table(columns)


def _plain(values: np.ndarray, name: str) -> np.ndarray:
    # A matrix of one row or one column becomes a vector, except for a known quantity, which may be that of one joint.
    values = values.astype(values.dtype.newbyteorder("="), copy=False)
    return values if name in KNOWN and values.ndim == 2 else values.squeeze()


def _of_matrix(
    name: str, values: np.ndarray, rows: int, names: Sequence[str] | None, source: str
) -> dict[str, np.ndarray]:
    if values.shape[0] != rows:
        values = values.T
    if values.shape[0] != rows:
        return {}
    joints = list(names) if names is not None else [f"joint_{i + 1}" for i in range(values.shape[1])]
    if len(joints) != values.shape[1]:
        raise LogError(
            f"{source}: '{name}' has {values.shape[1]} columns for {len(joints)} joints ({', '.join(joints)}); "
            "one a joint is allowed"
        )
    return {f"{name}.{joint}": np.ascontiguousarray(values[:, i]) for i, joint in enumerate(joints)}
