"""What a robot looks like: the shapes of its bodies, and where the bodies are along a course."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

import mujoco
import numpy as np
from numpy.typing import NDArray

from mjfriction.errors import SimulationError
from mjfriction.laws.law import Floats

Kind = Literal["sphere", "capsule", "ellipsoid", "cylinder", "box", "mesh"]
KINDS: dict[int, Kind] = {
    int(mujoco.mjtGeom.mjGEOM_SPHERE): "sphere",
    int(mujoco.mjtGeom.mjGEOM_CAPSULE): "capsule",
    int(mujoco.mjtGeom.mjGEOM_ELLIPSOID): "ellipsoid",
    int(mujoco.mjtGeom.mjGEOM_CYLINDER): "cylinder",
    int(mujoco.mjtGeom.mjGEOM_BOX): "box",
    int(mujoco.mjtGeom.mjGEOM_MESH): "mesh",
}
READABLE = {".stl", ".obj"}  # kinds of mesh files that MuJoCo reads
GREY = (0.62, 0.65, 0.69, 1.0)
BONE = 0.03  # radius of the bones drawn for a model without shapes, as a fraction of the arm's reach
SHORTEST_BONE = 1e-3  # m; bodies nearer to each other get no bone between them


@dataclass(frozen=True)
class Shape:
    """A shape on a body: ``size`` as MuJoCo counts it (half lengths, m), ``position`` (3,) and ``quaternion`` (w, x, y,
    z) in the body's frame, ``colour`` (4,) from 0 to 1; a mesh has ``vertices`` (n, 3) and ``faces`` (m, 3).
    """

    body: str
    kind: Kind
    size: tuple[float, float, float]
    position: tuple[float, float, float]
    quaternion: tuple[float, float, float, float]
    colour: tuple[float, float, float, float]
    vertices: Floats | None = None
    faces: NDArray[np.int32] | None = None


@dataclass(frozen=True)
class Scene:
    """Shapes on the bodies of a model, and where the bodies were in the world: ``position`` (n, bodies, 3) and
    ``quaternion`` (n, bodies, 4), w first.
    """

    bodies: tuple[str, ...]
    shapes: tuple[Shape, ...]
    position: Floats
    quaternion: Floats


def draw(spec: mujoco.MjSpec, path: Path, joints: Sequence[str], course: Floats) -> Scene:
    """Return the scene of a model along a course of its joints' positions (n, joints); the spec is changed in place.

    ``path`` is the file that the spec was read from.  A URDF's shapes are read from there: the visual ones where MuJoCo
    can read them, otherwise those for collisions.  A model without any shape is drawn as bones from joint to joint.
    Raises :class:`SimulationError` where a shape cannot be read.
    """
    try:
        model = spec_with_shapes(spec, path).compile()
    except (ValueError, OSError, ET.ParseError) as error:
        raise SimulationError(f"{path}: its shapes cannot be drawn: {' '.join(str(error).split())}") from None
    data = mujoco.MjData(model)
    places = np.array([model.jnt_qposadr[model.joint(name).id] for name in joints])
    bodies = tuple(model.body(i).name for i in range(model.nbody))
    position = np.empty((course.shape[0], model.nbody, 3))
    quaternion = np.empty((course.shape[0], model.nbody, 4))
    for k, row in enumerate(course):
        data.qpos[places] = row
        mujoco.mj_kinematics(model, data)
        position[k], quaternion[k] = data.xpos, data.xquat
    shapes = tuple(_shape(model, i) for i in range(model.ngeom) if int(model.geom_type[i]) in KINDS)
    return Scene(bodies, shapes, position, quaternion)


def spec_with_shapes(spec: mujoco.MjSpec, path: Path) -> mujoco.MjSpec:
    """Return the spec with visible shapes: a URDF's own, or bones where there are none."""
    spec.compiler.discardvisual = False
    if path.suffix.lower() == ".urdf":
        _add_urdf_shapes(spec, path)
    if not spec.geoms:
        _add_bones(spec)
    return spec


def _shape(model: mujoco.MjModel, i: int) -> Shape:
    shape = Shape(
        body=model.body(model.geom_bodyid[i]).name,
        kind=KINDS[int(model.geom_type[i])],
        size=tuple(model.geom_size[i].tolist()),
        position=tuple(model.geom_pos[i].tolist()),
        quaternion=tuple(model.geom_quat[i].tolist()),
        colour=tuple(model.geom_rgba[i].tolist()),
    )
    if shape.kind != "mesh":
        return shape
    mesh = int(model.geom_dataid[i])
    vertex, face = model.mesh_vertadr[mesh], model.mesh_faceadr[mesh]
    return replace(
        shape,
        vertices=np.array(model.mesh_vert[vertex : vertex + model.mesh_vertnum[mesh]], dtype=np.float64),
        faces=np.array(model.mesh_face[face : face + model.mesh_facenum[mesh]], dtype=np.int32),
    )


def _add_urdf_shapes(spec: mujoco.MjSpec, path: Path) -> None:
    for link in ET.parse(path).getroot().iter("link"):
        # A root link without a joint above it is the world's own body.
        body = spec.body(link.get("name", "")) or spec.worldbody
        readable = [_placed(shape, path) for kind in ("visual", "collision") for shape in link.findall(kind)]
        seen = next((kind for kind in ("visual", "collision") if any(r and r[0] == kind for r in readable)), None)
        for place in readable:
            if place is None or place[0] != seen:
                continue
            _, geometry, position, angles = place
            geom = body.add_geom(pos=position, rgba=GREY, contype=0, conaffinity=0, group=1, mass=0.0)
            geom.quat = _quaternion(angles)
            if geometry.tag == "mesh":
                file = _resolved(geometry.get("filename", ""), path)
                scale = [float(x) for x in geometry.get("scale", "1 1 1").split()]
                name = f"{link.get('name')} {file.stem} {len(spec.meshes)}"
                spec.add_mesh(
                    name=name, file=str(file), scale=scale, inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL
                )
                geom.type, geom.meshname = mujoco.mjtGeom.mjGEOM_MESH, name
            elif geometry.tag == "box":
                half = [0.5 * float(x) for x in geometry.get("size", "0 0 0").split()]
                geom.type, geom.size = mujoco.mjtGeom.mjGEOM_BOX, half
            elif geometry.tag == "sphere":
                geom.type, geom.size = mujoco.mjtGeom.mjGEOM_SPHERE, [float(geometry.get("radius", 0.0)), 0.0, 0.0]
            else:
                geom.type = mujoco.mjtGeom.mjGEOM_CYLINDER
                geom.size = [float(geometry.get("radius", 0.0)), 0.5 * float(geometry.get("length", 0.0)), 0.0]


def _placed(shape: ET.Element, path: Path) -> tuple[str, ET.Element, list[float], list[float]] | None:
    geometry = next(iter(shape.find("geometry") or ()), None)
    if geometry is None or geometry.tag not in ("mesh", "box", "sphere", "cylinder"):
        return None
    if geometry.tag == "mesh":
        file = _resolved(geometry.get("filename", ""), path)
        if not file.is_file():
            return None
    origin = shape.find("origin")
    where = {} if origin is None else origin.attrib
    place, angles = ([float(x) for x in where.get(key, "0 0 0").split()] for key in ("xyz", "rpy"))
    return shape.tag, geometry, place, angles


def _resolved(filename: str, path: Path) -> Path:
    """Return the path of a mesh, one that does not exist where MuJoCo cannot read the mesh.

    Packages are searched for in the folders above the model file.
    """
    inside = filename.removeprefix("package://").removeprefix("file://")
    named = (folder / inside for folder in path.resolve().parents)
    found = next((file for file in named if file.is_file()), path.parent / inside)
    if _readable(found):
        return found
    # A version that MuJoCo reads is often in a sibling folder: meshes/visual, meshes/collision.
    near = sorted(found.parent.parent.rglob(f"{found.stem}.*")) if filename.startswith("package://") else []
    return next((file for file in near if _readable(file)), path.parent / f"{found.stem} (unreadable)")


def _readable(file: Path) -> bool:
    if file.suffix.lower() not in READABLE or not file.is_file():
        return False
    with file.open("rb") as stream:
        start = stream.read(2048)
    # MuJoCo reads binary STL only; a text file begins with "solid" and contains "facet".
    return file.suffix.lower() != ".stl" or not (start.lstrip()[:5].lower() == b"solid" and b"facet" in start)


def _quaternion(angles: list[float]) -> Floats:
    out = np.empty(4)
    mujoco.mju_euler2Quat(out, np.array(angles), "XYZ")  # fixed axes, as in URDF
    return out


def _add_bones(spec: mujoco.MjSpec) -> None:
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    reach = max(float(np.max(np.linalg.norm(data.xpos - data.xpos[1], axis=1))), 0.1) if model.nbody > 1 else 1.0
    for body in list(spec.bodies):
        for child in body.bodies:
            if np.linalg.norm(child.pos) > SHORTEST_BONE:
                body.add_geom(
                    type=mujoco.mjtGeom.mjGEOM_CAPSULE,
                    fromto=[0.0, 0.0, 0.0, *child.pos],
                    size=[BONE * reach, 0.0, 0.0],
                    rgba=GREY,
                    contype=0,
                    conaffinity=0,
                    group=1,
                    mass=0.0,
                )
        if not body.bodies:
            body.add_geom(
                type=mujoco.mjtGeom.mjGEOM_SPHERE,
                size=[1.3 * BONE * reach, 0.0, 0.0],
                rgba=GREY,
                contype=0,
                conaffinity=0,
                group=1,
                mass=0.0,
            )
