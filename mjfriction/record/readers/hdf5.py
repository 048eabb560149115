"""Logs kept as HDF5."""

from __future__ import annotations

from pathlib import Path

import h5py
import numpy as np
import pyarrow as pa

from mjfriction.errors import LogError
from mjfriction.record.log import KNOWN
from mjfriction.record.readers.arrays import JOINT_NAMES, table_of


def read_table(path: Path) -> pa.Table:
    """Read the datasets of an HDF5 file, named as a log's columns or by groups: ``/position/elbow`` is position.elbow.

    Quantities such as ``position`` may be of shape (n, joints), with a dataset ``joint_names``.  Datasets in other
    groups are read under the last part of their path.  Raises :class:`LogError` when the file cannot be parsed.
    """
    arrays: dict[str, np.ndarray] = {}
    names: list[str] | None = None

    def visit(place: str, item: object) -> None:
        nonlocal names
        if not isinstance(item, h5py.Dataset):
            return
        *groups, own = place.split("/")
        if own in JOINT_NAMES and h5py.check_string_dtype(item.dtype) is not None:
            names = [str(name) for name in np.atleast_1d(item.asstr()[()])]
            return
        if groups and groups[-1] in KNOWN:
            own = f"{groups[-1]}.{own}"
        if own in arrays:
            raise LogError(f"{path}: two datasets are called '{own}'; keep one arm to a file, or name the joints apart")
        arrays[own] = np.asarray(item[()])

    try:
        with h5py.File(path, "r") as file:
            file.visititems(visit)
    except OSError as error:
        raise LogError(f"{path}: not a readable HDF5 file: {str(error).splitlines()[0]}") from None
    return table_of(arrays, names, str(path))
