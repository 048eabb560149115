"""A robot's model file, read with Pinocchio."""

from __future__ import annotations

import contextlib
import functools
import os
import sys
import tempfile
import xml.etree.ElementTree as ET
from collections.abc import Callable, Iterator
from pathlib import Path

import pinocchio as pin

from mjfriction.errors import RobotError

STANDARD_GRAVITY = (0.0, 0.0, -9.81)
MOST_KEPT = 8  # files


def root_of(path: Path) -> ET.Element:
    """Return the root element of a model file; :class:`RobotError` where it is missing or no XML."""
    if not path.is_file():
        raise RobotError(f"{path}: there is no such model file")
    try:
        return ET.parse(path).getroot()
    except ET.ParseError as error:
        raise RobotError(f"{path}: not well-formed XML: {error}") from None


def changed(path: Path) -> int:
    """Return when a file was written last, ns; 0 where there is none."""
    return path.stat().st_mtime_ns if path.is_file() else 0


def parse(path: Path, text: str | None) -> tuple[pin.Model, tuple[float, ...]]:
    """Return what a URDF or MJCF says as Pinocchio's model, and its gravity, m/s².

    ``text`` is what an MJCF says in plain words, and is read in the file's place: Pinocchio knows a part of MuJoCo's
    language only, and would lose masses without a word.

    Raises :class:`RobotError` with the file and what is wrong with it.
    """
    model, gravity = _parsed(path, changed(path), text)
    return model.copy(), gravity


@functools.lru_cache(MOST_KEPT)
def _parsed(path: Path, _changed: int, text: str | None) -> tuple[pin.Model, tuple[float, ...]]:
    # A diagnosis draws up the bodies of hundreds of robots with the same model file.
    root = root_of(path)
    if root.tag not in ("robot", "mujoco"):
        raise RobotError(f"{path}: the root element is <{root.tag}>; a URDF has <robot>, an MJCF <mujoco>")
    if root.tag == "robot":
        return _read(pin.buildModelFromUrdf, path, path, "URDF"), STANDARD_GRAVITY
    if text is None:
        raise RobotError(f"{path}: an MJCF is read in plain words; give them as text")
    with tempfile.TemporaryDirectory() as folder:
        plain = Path(folder) / path.name
        plain.write_text(text, encoding="utf-8")
        model = _read(pin.buildModelFromMJCF, plain, path, "MJCF")
    option = ET.fromstring(text).find("option")
    own = option.get("gravity") if option is not None else None
    return model, tuple(float(part) for part in own.split()) if own else STANDARD_GRAVITY


def _read(reader: Callable[[str], pin.Model], path: Path, told_of: Path, kind: str) -> pin.Model:
    try:
        with _native_messages_dropped():
            return reader(str(path))
    except Exception as error:  # Pinocchio's parsers raise ValueError, RuntimeError and boost's own kinds
        told = str(error).split("message:")[-1].split("\n")  # what comes before speaks of Pinocchio's own source files
        reason = next((line.strip() for line in told if line.strip()), type(error).__name__)
        raise RobotError(f"{told_of}: cannot be read as {kind}: {reason}") from None


def slides(joint: pin.JointModel) -> bool:
    """Return whether a joint is prismatic."""
    return "P" in joint.shortname().removeprefix("JointModel")


@contextlib.contextmanager
def _native_messages_dropped() -> Iterator[None]:
    # The C++ parsers write straight to file descriptor 2; our one line says what the user needs.
    sys.stderr.flush()
    saved = os.dup(2)
    with open(os.devnull, "wb") as nowhere:
        os.dup2(nowhere.fileno(), 2)
        try:
            yield
        finally:
            os.dup2(saved, 2)
            os.close(saved)
