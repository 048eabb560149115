"""A robot's model file, read with Pinocchio."""

from __future__ import annotations

import contextlib
import os
import sys
import tempfile
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pinocchio as pin

from mjfriction.errors import RobotError

STANDARD_GRAVITY = (0.0, 0.0, -9.81)


def root_of(path: Path) -> ET.Element:
    """Return the root element of a model file; :class:`RobotError` where it is missing or no XML."""
    if not path.is_file():
        raise RobotError(f"{path}: there is no such model file")
    try:
        return ET.parse(path).getroot()
    except ET.ParseError as error:
        raise RobotError(f"{path}: not well-formed XML: {error}") from None


def parse(path: Path, text: str | None) -> tuple[pin.Model, tuple[float, ...]]:
    """Return what a URDF or MJCF says as Pinocchio's model, and its gravity, m/s².

    ``text`` is an MJCF in plain words, to be read in the file's place.

    Raises :class:`RobotError` with the file and what is wrong with it.
    """
    if text is not None:
        with tempfile.TemporaryDirectory() as folder:
            plain = Path(folder) / path.name
            plain.write_text(text, encoding="utf-8")
            return _read(plain, ET.fromstring(text), path)
    root = root_of(path)
    unweighed = [body for body in root.iter("body") if body.find("geom") is not None and body.find("inertial") is None]
    if root.tag == "mujoco" and unweighed:
        raise RobotError(
            f"{path}: {len(unweighed)} of its bodies have shapes and no <inertial>; read it in plain words"
        )
    return _read(path, root, path)


def _read(path: Path, root: ET.Element, told_of: Path) -> tuple[pin.Model, tuple[float, ...]]:
    readers = {"robot": pin.buildModelFromUrdf, "mujoco": pin.buildModelFromMJCF}
    if root.tag not in readers:
        raise RobotError(f"{told_of}: the root element is <{root.tag}>; a URDF has <robot>, an MJCF <mujoco>")
    kind = "URDF" if root.tag == "robot" else "MJCF"
    nameless = sum(not body.get("name") for body in root.iter("body"))
    if nameless and root.tag == "mujoco":  # Pinocchio keeps bodies by their names, and would lose these
        raise RobotError(f"{told_of}: {nameless} of its bodies have no name; give every <body> one")
    try:
        with _native_messages_dropped():
            model = readers[root.tag](str(path))
    except Exception as error:  # Pinocchio's parsers raise ValueError, RuntimeError and boost's own kinds
        told = str(error).split("message:")[-1].split("\n")  # what comes before speaks of Pinocchio's own source files
        reason = next((line.strip() for line in told if line.strip()), type(error).__name__)
        raise RobotError(f"{told_of}: cannot be read as {kind}: {reason}") from None
    if root.tag == "mujoco":
        _mend_slides(model, root)
    option = root.find("option")
    own = option.get("gravity") if option is not None and root.tag == "mujoco" else None
    return model, tuple(float(part) for part in own.split()) if own else STANDARD_GRAVITY


def slides(joint: pin.JointModel) -> bool:
    """Return whether a joint is prismatic."""
    return "P" in joint.shortname().removeprefix("JointModel")


def _mend_slides(model: pin.Model, root: ET.Element) -> None:
    # Where angles are in degrees, as they are unless the file says otherwise, Pinocchio turns the ranges of slides too.
    if any(compiler.get("angle") == "radian" for compiler in root.iter("compiler")):
        return
    slides = [joint.idx_q for joint in model.joints if joint.nq == 1 and slides(joint)]
    for bounds in (model.lowerPositionLimit, model.upperPositionLimit):
        bounds[slides] = np.degrees(bounds[slides])


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
