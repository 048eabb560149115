"""MJCF files in the expanded, plain form that the rigid-body package reads."""

from __future__ import annotations

import functools
from pathlib import Path

from mjfriction.body.model_file import MOST_KEPT, changed, root_of
from mjfriction.errors import RobotError, SimulationError


def in_plain_words(path: Path) -> str | None:
    """Return an MJCF file's bodies and joints as text written by :func:`~mjfriction.sim.plain_tree.plain_tree`.

    None for any file that is not an MJCF.  Raises :class:`RobotError` if the file is missing or MuJoCo cannot read it.
    """
    return _as_it_was(path, changed(path))


@functools.lru_cache(MOST_KEPT)
def _as_it_was(path: Path, _changed: int) -> str | None:
    if root_of(path).tag != "mujoco":
        return None
    from mjfriction.sim.plain_tree import plain_tree  # noqa: PLC0415  (a URDF needs no MuJoCo)

    try:
        return plain_tree(path)
    except SimulationError as error:
        raise RobotError(str(error)) from None
