"""Names as steps of a recording's paths."""

from __future__ import annotations

import rerun as rr


def place_of(name: str) -> str:
    """Return the name of a joint, a body or a model as one step of a path, whatever characters it holds."""
    return rr.escape_entity_path_part(name)
