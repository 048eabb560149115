"""Model files as the rigid-body package can read them: MJCF in an expanded, plain form, and nothing beside a tree."""

from __future__ import annotations

import functools
from collections.abc import Collection, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from mjfriction.body.model_file import MOST_KEPT, changed, followers, root_of
from mjfriction.errors import RobotError, SimulationError

if TYPE_CHECKING:
    from mjfriction.sim.beside_the_tree import Beside


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
    if root_of(path).tag != "mujoco":
        for name in followers(path):
            if name in joints:
                raise RobotError(
                    _refusal(path, "<mimic>", [name], "leave joints that follow others out of the robot file")
                )
        return
    for one in _beside(path, changed(path)):
        if acts := one.acts_on(joints):
            raise RobotError(_refusal(path, one.what, sorted(acts), one.instead))


def coupled(path: Path, joints: Sequence[str]) -> frozenset[str]:
    """Return those of a model file's ``joints`` that follow others, or that an equality couples with others.

    Of joints whose coupling is gone with any of them, the first is not among these.
    """
    if root_of(path).tag != "mujoco":
        return frozenset(followers(path)) & frozenset(joints)
    out = frozenset[str]()
    for one in _beside(path, changed(path)):
        acting = sorted(one.acts_on(joints), key=joints.index) if one.couples else []
        out |= frozenset(acting[1:] if one.together else acting)
    return out


def _refusal(path: Path, what: str, acting: Sequence[str], instead: str) -> str:
    named = ", ".join(f"'{joint}'" for joint in acting)
    return (
        f"{path}: {what} acts on joint{'s' if len(acting) > 1 else ''} {named}, and predictions of efforts cannot "
        f"include that; {instead}"
    )


@functools.lru_cache(MOST_KEPT)
def _beside(path: Path, _changed: int) -> tuple[Beside, ...]:
    from mjfriction.sim.beside_the_tree import beside_the_tree  # noqa: PLC0415  (a URDF needs no MuJoCo)

    try:
        return beside_the_tree(path)
    except SimulationError as error:
        raise RobotError(str(error)) from None
