"""Machine code that is kept between processes, and let go once any kernel's source has changed.

Numba keeps code by the file that its function stands in, and does not see that another function, which it called or
inlined, was changed in another file: a law that was mended or added would go on as it was before.
"""

from __future__ import annotations

import contextlib
import hashlib
from pathlib import Path

KERNELS = ("laws", "sim", "control")  # rooms with compiled functions
STAMP = "kernels.stamp"


def let_go_of_stale_code(package: Path) -> None:
    """Remove the code that Numba keeps beside a package's sources where these are others than it was made from.

    Where nothing may be written there, Numba keeps nothing there either.
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
