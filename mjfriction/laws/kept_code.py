"""The cache of compiled code on disk, and its removal when any kernel's source has changed.

Numba's cache only watches the file that a function is defined in.  It does not notice changes in other files to
functions that were called or inlined, so a corrected or added law would have no effect.
"""

from __future__ import annotations

import contextlib
import hashlib
from pathlib import Path

KERNELS = ("laws", "sim", "control")  # packages with compiled functions
STAMP = "kernels.stamp"


def let_go_of_stale_code(package: Path) -> None:
    """Remove Numba's cached code next to a package's sources if the sources changed since it was compiled.

    Where the directory is not writable, Numba caches nothing there either.
    """
    sources = sorted(file for room in KERNELS for file in (package / room).glob("*.py"))
    states = [(file.parts[-2:], (state := file.stat()).st_mtime_ns, state.st_size) for file in sources]
    told = hashlib.sha256(repr(states).encode()).hexdigest()
    stamp = package / KERNELS[0] / "__pycache__" / STAMP
    with contextlib.suppress(OSError):
        if stamp.is_file() and stamp.read_text(encoding="ascii") == told:
            return
        for room in KERNELS:
            for file in (package / room / "__pycache__").glob("*.nb[ci]"):
                file.unlink(missing_ok=True)
        stamp.parent.mkdir(exist_ok=True)
        fresh = stamp.with_suffix(".new")
        fresh.write_text(told, encoding="ascii")
        fresh.replace(stamp)
