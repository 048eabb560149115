"""Shapes of a model file: those that masses depend on, and those whose files are not there."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

import mujoco

from mjfriction.errors import SimulationError


def leave_out_missing(spec: mujoco.MjSpec, path: Path) -> None:
    """Delete, in place, the shapes of a spec whose files of meshes or heights are missing, and missing pictures.

    ``path`` is the file that the spec was read from.  Raises :class:`SimulationError` if the mass of a body that moves
    would have to be computed from such a shape.
    """
    folder = path.parent / spec.meshdir
    meshes, fields = _lost(spec.meshes, folder), _lost(spec.hfields, folder)
    pictures = _lost(spec.textures, path.parent / spec.texturedir)
    shapes = [geom for geom in spec.geoms if geom.meshname in meshes or geom.hfieldname in fields]
    if not (meshes or fields or pictures) or _compiles(spec):
        return
    for geom in shapes:
        if weighs(spec, geom):
            raise SimulationError(
                f"{path}: body '{geom.parent.name}' states no inertia, and the mesh to compute it from is missing: "
                f"{meshes[geom.meshname]}; bring the mesh, or write the body's <inertial> into the model"
            )
    for material in spec.materials:
        material.textures = ["" if name in pictures else name for name in material.textures]
    assets = ((spec.meshes, meshes), (spec.hfields, fields), (spec.textures, pictures))
    gone = [one for elements, lost in assets for one in elements if one.name in lost]
    for element in (*shapes, *gone):
        spec.delete(element)


def _compiles(spec: mujoco.MjSpec) -> bool:
    # Files of an attached model, and names whose folders are stripped, are found by MuJoCo only.
    try:
        spec.copy().compile()
    except ValueError:
        return False
    return True


def _lost(elements: Iterable[Any], folder: Path) -> dict[str, Path]:
    # Where files of those elements should be of which any is missing, by the elements' names.
    named = [(one.name, file) for one in elements for file in (one.file, *getattr(one, "cubefiles", ())) if file]
    return {name: folder / file for name, file in named if not (folder / file).is_file()}


def weighs(spec: mujoco.MjSpec, geom: mujoco.MjsGeom) -> bool:
    """Return whether a mass that moves is computed from a shape of the spec."""
    by_shape = spec.compiler.inertiafromgeom == mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_TRUE
    first, last = spec.compiler.inertiagrouprange
    heavy = first <= geom.group <= last and geom.mass != 0.0 and geom.density != 0.0
    return heavy and moves(geom.parent) and (by_shape or not geom.parent.explicitinertial)


def moves(body: mujoco.MjsBody | None) -> bool:
    """Return whether a joint moves a body, its own or one before it."""
    return body is not None and (bool(body.joints) or moves(body.parent))
