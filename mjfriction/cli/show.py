"""Output of a verb's result on a terminal: in 80 columns, followed by where the files are."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.console import Console


def show(printing: Callable[[Console], None], out: Path | None, *, recorded: bool = True) -> None:
    """Print a result to a console, then where its files are and how to open them."""
    from rich.console import Console

    from mjfriction.report.text import WIDTH

    console = Console(width=WIDTH, highlight=False, soft_wrap=False)
    printing(console)
    if out is not None:
        console.print(f"\nResults in {out}. Open in a browser:", soft_wrap=True, markup=False)
        console.print(f"  {out / 'report.html'}", soft_wrap=True, markup=False)
        if recorded:
            console.print("and in Rerun:", markup=False)
            console.print(f"  mjfriction view {out}", soft_wrap=True, markup=False)
