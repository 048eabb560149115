"""The command run in this process: one of its own takes seconds before it begins."""

from __future__ import annotations

import contextlib
import io
import subprocess
import sys
from pathlib import Path
from unittest.mock import patch

from mjfriction.cli.main import run


def mjfriction_here(*words: object, cwd: Path | None = None) -> subprocess.CompletedProcess[str]:
    """Run the command with these words and return what came of it."""
    told = list(map(str, words))
    out, err = io.StringIO(), io.StringIO()
    with (
        contextlib.redirect_stdout(out),
        contextlib.redirect_stderr(err),
        contextlib.chdir(cwd or Path.cwd()),
        patch.object(sys, "argv", ["mjfriction", *told]),
    ):
        try:
            run()
            status = 0
        except SystemExit as ended:
            status = ended.code if isinstance(ended.code, int) else int(ended.code is not None)
    return subprocess.CompletedProcess(told, status, out.getvalue(), err.getvalue())
