"""Draft a robot file from a model file alone."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import tomli_w

from mjfriction.body.model import load_body, single_axis_joints
from mjfriction.errors import RobotError, suggestion
from mjfriction.robot.plain_model import coupled, in_plain_words
from mjfriction.robot.robot import packaged_model, resolve_model

HEAD = """\
# A draft. What is left out is taken from the model file, or is none. Take the '#' away from what you know of the
# drives: gear_ratio (motor radians per joint radian, or per metre of a slide), torque_constant (N·m/A at the motor),
# rotor_inertia (kg·m² at the motor); a log of currents needs the first two. The numbers behind '#' are examples, but
# those of friction are the model file's.
"""
GRIPPERS = ("finger", "gripper", "knuckle")  # words in the names of gripper joints, which are held while an arm moves
DRIVE = "# actuator = { gear_ratio = 100.0, torque_constant = 0.1, rotor_inertia = 1e-5 }"
FRICTION = '# friction = {{ law = "coulomb_viscous", parameters = {{ coulomb = {:.4g}, viscous = {:.4g} }} }}'


def draft_robot(model: str, folder: Path, wanted: Sequence[str] | None = None) -> str:
    """Return the text of a robot file for a URDF or MJCF, to be written into ``folder``.

    ``model`` is a path, or ``package://example-robot-data/…``.  The joints are those of ``wanted``, in that order, or
    by default every hinge and slide of the model except a gripper's and those that are coupled with others, by
    ``<mimic>`` or an equality.  Raises :class:`RobotError` for a model that cannot be read or has no such joints.
    """
    packaged, path = model.startswith("package://"), _path(model)
    text = in_plain_words(path)
    known = single_axis_joints(path, text)
    for name in wanted or ():
        if name not in known:
            raise RobotError(
                f"{path}: there is no hinge or slide '{name}' on a body of its own{suggestion(name, known)} "
                f"There are {', '.join(known) or 'none'}; joints that share a body need one each"
            )
    following = coupled(path, known)
    joints = list(wanted or _of_the_arm([name for name in known if name not in following]))
    if not joints:
        raise RobotError(
            f"{path}: the model has no hinge and no slide on a body of its own; joints that share a body need one each"
        )
    body = load_body(path, joints, text=text)
    named = model if packaged else packaged_model(path) or _seen_from(folder, path)
    lines = [HEAD, _line("name", path.stem), _line("model", named)]
    for i, name in enumerate(joints):
        unit = "m" if body.sliding[i] else "rad"
        kind = "slides" if body.sliding[i] else "turns"
        limited = np.isfinite(body.lower[i]) and np.isfinite(body.upper[i])
        range_ = f" from {body.lower[i]:.4g} to {body.upper[i]:.4g} {unit}" if limited else " without limits"
        friction = FRICTION.format(body.dry_friction[i], body.damping[i])
        lines += ["", "[[joint]]", f"{_line('name', name)}  # {kind}{range_}", DRIVE, friction]
    return "\n".join(lines) + "\n"


def joints_of(model: str) -> tuple[str, ...]:
    """Return every hinge and slide of a URDF or MJCF; ``model`` and errors as in :func:`draft_robot`."""
    path = _path(model)
    return single_axis_joints(path, in_plain_words(path))


def _path(model: str) -> Path:
    return resolve_model(model, Path()) if model.startswith("package://") else Path(model)


def _of_the_arm(known: Sequence[str]) -> list[str]:
    # Logs rarely contain a gripper's joints; a model that has no others keeps them.
    return [name for name in known if not any(word in name.lower() for word in GRIPPERS)] or list(known)


def _seen_from(folder: Path, path: Path) -> str:
    return Path(os.path.relpath(path.resolve(), folder.resolve())).as_posix()


def _line(key: str, value: str) -> str:
    return tomli_w.dumps({key: value}).strip()
