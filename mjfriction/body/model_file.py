"""A robot's model file, read with Pinocchio."""

from __future__ import annotations

import contextlib
import functools
import os
import sys
import tempfile
import xml.etree.ElementTree as ET
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pinocchio as pin
from numpy.polynomial import Polynomial

from mjfriction.errors import RobotError

STANDARD_GRAVITY = (0.0, 0.0, -9.81)
MOST_KEPT = 8  # model files kept in the cache


def root_of(path: Path) -> ET.Element:
    """Return the root element of a model file; :class:`RobotError` if the file is missing or not XML."""
    if not path.is_file():
        raise RobotError(f"{path}: there is no such model file")
    try:
        return ET.parse(path).getroot()
    except ET.ParseError as error:
        raise RobotError(f"{path}: not well-formed XML: {error}") from None


def followers(path: Path) -> tuple[str, ...]:
    """Return the joints of a URDF that follow others by ``<mimic>``; none of any other file."""
    return tuple(str(joint.get("name")) for joint in root_of(path).findall("joint") if joint.find("mimic") is not None)


def changed(path: Path) -> int:
    """Return the time of a file's last modification, ns; 0 if there is no such file."""
    return path.stat().st_mtime_ns if path.is_file() else 0


def parse(path: Path, text: str | None) -> tuple[pin.Model, tuple[float, ...]]:
    """Return a URDF or MJCF as a Pinocchio model, and its gravity, m/s².

    ``text`` is an MJCF in expanded form and is read instead of the file: Pinocchio supports only part of MuJoCo's
    language and would silently lose masses.

    Raises :class:`RobotError` naming the file and what is wrong with it.
    """
    model, gravity = _parsed(path, changed(path), text)
    return model.copy(), gravity


@functools.lru_cache(MOST_KEPT)
def _parsed(path: Path, _changed: int, text: str | None) -> tuple[pin.Model, tuple[float, ...]]:
    # Cached because a diagnosis builds the bodies of hundreds of robots from the same model file.
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


@dataclass(frozen=True)
class Unread:
    """What an MJCF says of a joint that Pinocchio does not read.

    ``reference`` (rad or m) is where the file has the joint.  ``spring`` (4,) has the coefficients of the torque that
    its spring demands of a drive, as a polynomial in position, constant first.  ``bent_damping`` says whether its
    damping has terms of higher order than the first.  ``before`` is the last joint of its body, if that is another
    one: that joint moves the body's mass.
    """

    reference: float
    spring: np.ndarray
    bent_damping: bool
    before: str | None


def unread(text: str | None) -> dict[str, Unread]:
    """Return what an MJCF in expanded form says of its joints that Pinocchio does not read; empty without ``text``."""
    out = {}
    for joint in ET.fromstring(text).iter("joint") if text else ():
        stiffness, bent = (_numbers(joint.get(key, "0")) for key in ("stiffness", "bent"))
        torque = Polynomial([0.0, *stiffness])(Polynomial([-float(joint.get("springref", 0.0)), 1.0])).coef
        spring = np.pad(torque, (0, 4 - torque.size)) if any(stiffness) else np.zeros(4)
        reference = float(joint.get("ref", 0.0))
        out[joint.get("name", "")] = Unread(reference, spring, any(bent), joint.get("before"))
    return out


def _numbers(text: str) -> list[float]:
    return [float(part) for part in text.split()]


def _read(reader: Callable[[str], pin.Model], path: Path, told_of: Path, kind: str) -> pin.Model:
    try:
        with _native_messages_dropped():
            return reader(str(path))
    except Exception as error:  # Pinocchio's parsers raise ValueError, RuntimeError and boost's own kinds
        told = str(error).split("message:")[-1].split("\n")  # the part before refers to Pinocchio's own source files
        reason = next((line.strip() for line in told if line.strip()), type(error).__name__)
        raise RobotError(f"{told_of}: cannot be read as {kind}: {reason}") from None


def slides(joint: pin.JointModel) -> bool:
    """Return whether a joint is prismatic."""
    return "P" in joint.shortname().removeprefix("JointModel")


@contextlib.contextmanager
def _native_messages_dropped() -> Iterator[None]:
    # The C++ parsers write directly to file descriptor 2; our one-line message says what the user needs.
    sys.stderr.flush()
    saved = os.dup(2)
    with open(os.devnull, "wb") as nowhere:
        os.dup2(nowhere.fileno(), 2)
        try:
            yield
        finally:
            os.dup2(saved, 2)
            os.close(saved)
