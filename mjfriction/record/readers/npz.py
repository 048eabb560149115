"""Logs kept as NumPy archives; never as pickles."""

from __future__ import annotations

import zipfile
from pathlib import Path

import numpy as np
import pyarrow as pa

from mjfriction.errors import LogError
from mjfriction.record.readers.arrays import JOINT_NAMES, table_of


def read_table(path: Path) -> pa.Table:
    """Read an .npz archive of arrays named as a log's columns, or of quantities (``position``, …) of shape (n, joints)
    with ``joint_names``; :class:`LogError` when it cannot be parsed or holds pickled objects.
    """
    try:
        with np.load(path, allow_pickle=False) as archive:
            arrays = {name: archive[name] for name in archive.files}
    except (OSError, ValueError, EOFError, TypeError, AttributeError, zipfile.BadZipFile) as error:
        raise LogError(f"{path}: not a readable NumPy archive: {str(error).splitlines()[0]}") from None
    listed = next((arrays[name] for name in JOINT_NAMES if name in arrays), None)
    return table_of(arrays, None if listed is None else [str(name) for name in np.ravel(listed)], str(path))
