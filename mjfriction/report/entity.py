"""Names as parts of a recording's entity paths."""

from __future__ import annotations

import rerun as rr


def place_of(name: str) -> str:
    """Return the name of a joint, a body or a model as one part of an entity path, with special characters escaped."""
    return rr.escape_entity_path_part(name)
