"""Shapes of a model file: those that masses depend on, and those whose meshes are not there."""

from __future__ import annotations

from pathlib import Path

import mujoco

from mjfriction.errors import SimulationError


def leave_out_missing(spec: mujoco.MjSpec, path: Path) -> int:
    """Delete the shapes of a spec whose mesh files are missing, in place; return how many there were.

    ``path`` is the file that the spec was read from.  Raises :class:`SimulationError` if the mass of a body that moves
    would have to be computed from such a shape.
    """
    folder = path.parent / spec.meshdir
    lost = {mesh.name: mesh.file for mesh in spec.meshes if mesh.file and not (folder / mesh.file).is_file()}
    shapes = [geom for geom in spec.geoms if geom.meshname in lost]
    for geom in shapes:
        if weighs(spec, geom):
            raise SimulationError(
                f"{path}: body '{geom.parent.name}' states no inertia, and the mesh to compute it from is missing: "
                f"{folder / lost[geom.meshname]}; bring the mesh, or write the body's <inertial> into the model"
            )
    for element in (*shapes, *(mesh for mesh in spec.meshes if mesh.name in lost)):
        spec.delete(element)
    return len(shapes)


def weighs(spec: mujoco.MjSpec, geom: mujoco.MjsGeom) -> bool:
    """Return whether a mass that moves is computed from a shape of the spec."""
    by_shape = spec.compiler.inertiafromgeom == mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_TRUE
    first, last = spec.compiler.inertiagrouprange
    heavy = first <= geom.group <= last and geom.mass != 0.0 and geom.density != 0.0
    return heavy and moves(geom.parent) and (by_shape or not geom.parent.explicitinertial)


def moves(body: mujoco.MjsBody | None) -> bool:
    """Return whether a joint moves a body, its own or one before it."""
    return body is not None and (bool(body.joints) or moves(body.parent))
