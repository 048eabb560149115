"""Progress on a terminal, silence in a pipe."""

from __future__ import annotations

import contextlib
import sys
from collections.abc import Iterator

from mjfriction.progress import Tell, silently

READ = 0.3  # of what a command takes that goes through a log once, when the log is read
PREDICTED = 0.6  # of a prediction's, when the rows are predicted
WRITING = 0.95  # of what a diagnosis takes, or an identification, when its report is written


@contextlib.contextmanager
def telling() -> Iterator[Tell]:
    """Give what tells a person who watches what is going on, since when, and about how long it will be."""
    if not sys.stderr.isatty():
        yield silently
        return
    from rich.console import Console
    from rich.progress import BarColumn, Progress, SpinnerColumn, TextColumn, TimeElapsedColumn, TimeRemainingColumn

    columns = (
        SpinnerColumn(),
        TextColumn("{task.description}"),
        BarColumn(bar_width=20),
        TimeElapsedColumn(),
        TextColumn("left about"),
        TimeRemainingColumn(),
    )
    with Progress(*columns, console=Console(stderr=True), transient=True) as progress:
        task = progress.add_task("beginning", total=None)

        def tell(step: str, done: float | None = None) -> None:
            if done is None:
                progress.update(task, description=step)
            else:
                progress.update(task, description=step, total=1.0, completed=done)

        yield tell
