"""Read robot files, with one-line error messages, and write them so that they read back equal."""

from __future__ import annotations

import re
import shutil
import tomllib
import typing
from pathlib import Path
from typing import Any

import tomli_w
from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from mjfriction.errors import LawError, RobotError, suggestion
from mjfriction.robot.robot import Robot, bundled_robots
from mjfriction.robot.schema import RobotTable

MODELS = {".urdf", ".xml", ".mjcf"}
TYPES = ("float", "int", "str", "bool")
MOST_SHOWN = 80  # characters of a wrong value that a message shows


def read_robot(source: Path | str) -> Robot:
    """Read a robot file, the ``robot.toml`` of a folder, or one of the bundled robots by its name.

    Raises :class:`RobotError` naming the file, the key and what is allowed.
    """
    path = Path(source)
    if not path.suffix and not path.exists():
        bundled = bundled_robots()
        if str(source) not in bundled:
            raise RobotError(
                f"robot '{source}' is neither a file nor a bundled robot{suggestion(str(source), bundled)} "
                f"Bundled: {', '.join(bundled)}"
            )
        path = bundled[str(source)]
    if path.is_dir():
        path = path / "robot.toml"
    if not path.is_file():
        raise RobotError(f"{path}: there is no such robot file; bundled robots are {', '.join(bundled_robots())}")
    try:
        table = tomllib.loads(path.read_text(encoding="utf-8"))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        if path.suffix.lower() in MODELS:
            raise RobotError(
                f"{path}: this is a model file; a robot file names it and states the drives: "
                f"mjfriction new {path} --out {path.with_suffix('.toml')} drafts one"
            ) from None
        raise RobotError(f"{path}: not valid TOML: {error}") from None
    return Robot(_checked(table, path), path.resolve().parent)


def write_robot(robot: Robot, folder: Path, *, comment: str = "") -> Path:
    """Write ``robot.toml`` and the model file it names into a folder, and return the robot file's path.

    A model from example-robot-data keeps its package name.  A model that needs no other files is copied next to the
    robot file; one that includes other files is named by its absolute path.
    """
    table = robot.table
    if not table.model.startswith("package://"):
        original = robot.model_path.resolve()
        if _stands_alone(original):
            shutil.copyfile(original, folder / original.name)
            table = table.model_copy(update={"model": original.name})
        else:
            table = table.model_copy(update={"model": str(original)})
    data = table.model_dump(mode="json", exclude_defaults=True, exclude_none=True)
    text = "".join(f"# {line}\n" for line in comment.splitlines()) + tomli_w.dumps(data, multiline_strings=False)
    path = folder / "robot.toml"
    path.write_text(text, encoding="utf-8")
    return path


def _stands_alone(model: Path) -> bool:
    text = model.read_text(encoding="utf-8", errors="replace")
    if "<mujoco" in text:
        return re.search(r"<include|\bfile\s*=", text) is None
    return True  # a URDF's meshes are only visual; masses and inertias are in the file itself


def _checked(table: dict[str, Any], path: Path) -> RobotTable:
    try:
        return RobotTable.model_validate(table)
    except ValidationError as error:
        # A misspelt key is reported both as unknown and as missing; the former says more.
        worst = min(error.errors(), key=lambda detail: detail["type"] != "extra_forbidden")
        raise RobotError(_one_line(worst, table, path)) from None
    except LawError as error:
        raise RobotError(f"{path}: {error}") from None


def _one_line(detail: ErrorDetails, table: dict[str, Any], path: Path) -> str:
    where = _place(detail["loc"], table)
    if detail["type"] == "extra_forbidden":
        allowed = list(_model_at(detail["loc"][:-1]).model_fields)
        key = str(detail["loc"][-1])
        return f"{path}: {where}: unknown key '{key}'{suggestion(key, allowed)} Allowed: {', '.join(allowed)}"
    if detail["type"] == "missing" and isinstance(detail["loc"][-1], int):
        return f"{path}: '{where}' has {len(detail['input'])} values, which are too few"
    if detail["type"] == "missing":
        return f"{path}: '{where}' is missing; state it"
    said = repr(detail["input"])
    given = f" (given: {said})" if len(said) <= MOST_SHOWN else ""
    return f"{path}: {where}: {detail['msg'].removeprefix('Value error, ')}{given}"


def _place(location: tuple[int | str, ...], table: dict[str, Any]) -> str:
    # Example: ('joint', 3, 'friction', 0, 'side') becomes "joint 'elbow_joint': friction.side".  Where a value may be
    # of several types, its location ends with the one that was tried.
    words = [part for part in location if isinstance(part, str) and part not in TYPES and "[" not in part]
    if len(location) > 1 and location[0] == "joint" and isinstance(location[1], int):
        joint = table["joint"][location[1]]
        name = (
            joint.get("name", f"number {location[1] + 1}") if isinstance(joint, dict) else f"number {location[1] + 1}"
        )
        return f"joint '{name}': {'.'.join(words[1:]) or 'table'}"
    return ".".join(words) or "file"


def _model_at(location: tuple[int | str, ...]) -> type[BaseModel]:
    model: type[BaseModel] = RobotTable
    for part in location:
        if isinstance(part, str) and part in model.model_fields:
            model = next(_models_in(model.model_fields[part].annotation), model)
    return model


def _models_in(annotation: Any) -> typing.Iterator[type[BaseModel]]:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        yield annotation
    for argument in typing.get_args(annotation):
        yield from _models_in(argument)
