"""Progress shown on a terminal, and nothing in a pipe."""

from __future__ import annotations

import contextlib
import sys
from collections.abc import Iterator

from mjfriction.progress import Tell, silently

READ = 0.3  # share of the time of a command that goes through a log once, after which the log has been read
PREDICTED = 0.6  # share of the time of a prediction, after which the rows have been predicted
WRITING = 0.95  # share of the time of a diagnosis or an identification, after which the report is written


@contextlib.contextmanager
def telling() -> Iterator[Tell]:
    """Yield a callback that shows the current step, the time elapsed and the time left, where stderr is a terminal."""
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
