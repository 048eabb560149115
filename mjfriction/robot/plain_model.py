"""Model files as the rigid-body package can read them: MJCF in an expanded, plain form, and nothing beside a tree."""

from __future__ import annotations

import functools
from collections.abc import Collection
from pathlib import Path

from mjfriction.body.model_file import MOST_KEPT, changed, followers, root_of
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


def check_tree(path: Path, joints: Collection[str]) -> None:
    """Raise :class:`RobotError` if a model file has forces on ``joints`` that no balance of its bodies has.

    MuJoCo would simulate them, and whatever they make would look like an error of the model.
    """
    for what, acting, instead in _beside(path, changed(path), frozenset(joints)):
        raise RobotError(
            f"{path}: {what} acts on joint '{acting}', and predictions of efforts cannot include that; {instead}"
        )


@functools.lru_cache(MOST_KEPT)
def _beside(path: Path, _changed: int, joints: frozenset[str]) -> tuple[tuple[str, str, str], ...]:
    if root_of(path).tag != "mujoco":
        instead = "leave joints that follow others out of the robot file"
        return tuple(("<mimic>", name, instead) for name in followers(path) if name in joints)
    from mjfriction.sim.beside_the_tree import beside_the_tree  # noqa: PLC0415  (a URDF needs no MuJoCo)

    try:
        beside = beside_the_tree(path)
    except SimulationError as error:
        raise RobotError(str(error)) from None
    return tuple((one.what, sorted(acts)[0], one.instead) for one in beside if (acts := one.acts_on(joints)))
