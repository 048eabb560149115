"""MJCF files in the plain words in which the rigid-body room reads them."""

from __future__ import annotations

import functools
from pathlib import Path

from mjfriction.body.model_file import MOST_KEPT, changed, root_of
from mjfriction.errors import RobotError, SimulationError


def in_plain_words(path: Path) -> str | None:
    """Return what an MJCF file says of bodies and joints, as :func:`~mjfriction.sim.plain_tree.plain_tree` puts it;
    None for any other file.

    Raises :class:`RobotError` where there is no such file, or MuJoCo cannot read it.
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
