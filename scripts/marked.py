"""The parts of hand-written pages that scripts write, between a begin comment and an end comment."""

from __future__ import annotations

import re
from pathlib import Path


def write_marked(page: Path, name: str, text: str) -> None:
    """Put a text between ``<!-- name begin -->`` and ``<!-- name end -->`` of a page.

    Raises :class:`ValueError` where the page has no such place.
    """
    begin, end = f"<!-- {name} begin -->", f"<!-- {name} end -->"
    written, places = re.subn(
        f"{begin}.*?{end}", lambda _: f"{begin}\n{text}\n{end}", page.read_text("utf-8"), flags=re.DOTALL
    )
    if places != 1:
        raise ValueError(f"{page} has {places} places marked '{name}'; one is needed")
    page.write_text(written, encoding="utf-8")
