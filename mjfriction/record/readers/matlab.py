"""Logs kept as MATLAB .mat files, of version 7.3 (which is HDF5) or earlier."""

from __future__ import annotations

import zlib
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pyarrow as pa
from scipy.io import loadmat
from scipy.io.matlab import MatReadError

from mjfriction.errors import LogError
from mjfriction.record.log import KNOWN
from mjfriction.record.readers import hdf5
from mjfriction.record.readers.arrays import JOINT_NAMES, table_of


def read_table(path: Path) -> pa.Table:
    """Read the variables of a .mat file and the fields of its only struct, as :mod:`~.npz` reads arrays.

    MATLAB allows no dots in names: ``position_elbow`` is read as position.elbow.  Raises :class:`LogError` when the
    file cannot be parsed.
    """
    if h5py.is_hdf5(path):
        return _dotted(hdf5.read_table(path))
    try:
        variables = loadmat(path, squeeze_me=True, struct_as_record=False)
    except (MatReadError, ValueError, OSError, TypeError, IndexError, NotImplementedError, zlib.error) as error:
        raise LogError(f"{path}: not a readable MATLAB file: {str(error).splitlines()[0]}") from None
    own = {name: value for name, value in variables.items() if not name.startswith("__")}
    structs = [value for value in own.values() if hasattr(value, "_fieldnames")]
    if len(structs) == 1:
        own |= {name: getattr(structs[0], name) for name in structs[0]._fieldnames}
    names = next((_words(own[name]) for name in JOINT_NAMES if name in own), None)
    arrays = {name: value for name, value in own.items() if isinstance(value, np.ndarray)}
    return _dotted(table_of(arrays, names, str(path)))


def _words(value: Any) -> list[str]:
    return [str(word).strip() for word in np.ravel(value)]


def _dotted(table: pa.Table) -> pa.Table:
    def dotted(name: str) -> str:
        quantity = next((known for known in sorted(KNOWN, key=len, reverse=True) if name.startswith(f"{known}_")), None)
        return name if "." in name or quantity is None else f"{quantity}.{name.removeprefix(f'{quantity}_')}"

    return table.rename_columns([dotted(name) for name in table.schema.names])
