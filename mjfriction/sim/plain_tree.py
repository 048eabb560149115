"""An MJCF file reduced to the plain tree of bodies that MuJoCo compiles from it.

MJCF has defaults, angle units, frames, included files and masses computed from shapes, and only MuJoCo itself reads all
of that.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterable
from pathlib import Path

import mujoco
import numpy as np

from mjfriction.errors import SimulationError
from mjfriction.sim.shapes import leave_out_missing, weighs
from mjfriction.sim.spec import nameless

Disable = mujoco.mjtDisableBit
TYPES = {
    int(mujoco.mjtJoint.mjJNT_FREE): "free",
    int(mujoco.mjtJoint.mjJNT_BALL): "ball",
    int(mujoco.mjtJoint.mjJNT_SLIDE): "slide",
    int(mujoco.mjtJoint.mjJNT_HINGE): "hinge",
}


def plain_tree(path: Path) -> str:
    """Return an equivalent MJCF file that states its bodies and joints in plain numbers.

    It has every body's pose and inertia and every joint's axis, limits, damping, dry friction, armature and spring,
    with angles in radians and without shapes.  Bodies and joints without a name get one.  A body with several joints
    becomes a chain of bodies with one joint each, of which the last has its mass.  Raises
    :class:`SimulationError` when MuJoCo cannot read the file, or cannot compile the parts that masses depend on: shapes
    of bodies whose inertia is stated are ignored.
    """
    try:
        spec = mujoco.MjSpec.from_file(str(path))
        _strip(spec)
        leave_out_missing(spec, path)
        return _in_words(spec.compile())
    except ValueError as error:
        raise SimulationError(f"{path}: MuJoCo cannot read it: {' '.join(str(error).split())}") from None


def _strip(spec: mujoco.MjSpec) -> None:
    # Delete everything that no mass that moves depends on, so that missing files (e.g. of meshes or textures) do no
    # harm.
    spec.compiler.fusestatic = False
    _delete(spec, [geom for geom in spec.geoms if not weighs(spec, geom)])
    for kind in (spec.sensors, spec.actuators, spec.tendons, spec.equalities, spec.pairs, spec.excludes, spec.keys):
        _delete(spec, kind)
    for geom in spec.geoms:
        geom.material = ""
    used = {geom.meshname for geom in spec.geoms}
    _delete(spec, [mesh for mesh in spec.meshes if mesh.name not in used])
    for kind in (spec.skins, spec.flexes, spec.materials, spec.textures):
        _delete(spec, kind)


def _delete(spec: mujoco.MjSpec, elements: Iterable[object]) -> None:
    for element in list(elements):
        spec.delete(element)


def _in_words(model: mujoco.MjModel) -> str:
    root = ET.Element("mujoco")
    ET.SubElement(root, "compiler", angle="radian", autolimits="false")
    gravity = np.zeros(3) if _disabled(model, Disable.mjDSBL_GRAVITY) else model.opt.gravity
    ET.SubElement(root, "option", gravity=_words(gravity))
    # Of what is on the world, Pinocchio reads the first body only, and not how it is placed unless a joint moves it.
    # All are on one more, which is fixed: a table and an arm, two arms, or one arm that hangs from the ceiling.
    nodes = {0: ET.SubElement(ET.SubElement(root, "worldbody"), "body", name="on the world")}
    for i in range(1, model.nbody):
        first, name = int(model.body_jntadr[i]), model.body(i).name or f"body {i}"
        joints = [_joint(model, j) for j in range(first, first + int(model.body_jntnum[i]))]
        parent, placed = nodes[int(model.body_parentid[i])], {"pos": _words(model.body_pos[i])}
        placed["quat"] = _words(model.body_quat[i])
        for joint in joints[:-1]:
            parent, placed = ET.SubElement(parent, "body", placed, name=f"{name} behind {joint['name']}"), {}
            ET.SubElement(parent, "joint", joint, before=joints[-1]["name"])  # no attribute of MJCF
        body = nodes[i] = ET.SubElement(parent, "body", placed, name=name)
        if model.body_mass[i] > 0.0:
            ET.SubElement(
                body,
                "inertial",
                pos=_words(model.body_ipos[i]),
                quat=_words(model.body_iquat[i]),
                mass=_words([model.body_mass[i]]),
                diaginertia=_words(model.body_inertia[i]),
            )
        for joint in joints[-1:]:
            ET.SubElement(body, "joint", joint)
    return ET.tostring(root, encoding="unicode")


def _joint(model: mujoco.MjModel, j: int) -> dict[str, str]:
    kind, dof = TYPES[int(model.jnt_type[j])], int(model.jnt_dofadr[j])
    limited = bool(model.jnt_limited[j])
    damped = not _disabled(model, Disable.mjDSBL_DAMPER)
    rubs = not _disabled(model, Disable.mjDSBL_FRICTIONLOSS)
    out = {
        "name": model.joint(j).name or nameless(j),
        "type": kind,
        "pos": _words(model.jnt_pos[j]),
        "limited": "true" if limited else "false",
        "damping": _words([damped * model.dof_damping[dof]]),
        # No attribute of MJCF: Pinocchio reads one number of damping.
        "bent": _words(damped * model.dof_dampingpoly[dof]),
        "frictionloss": _words([rubs * model.dof_frictionloss[dof]]),
        "armature": _words([model.dof_armature[dof]]),
    }
    if kind in ("slide", "hinge"):
        if limited:
            out["range"] = _words(model.jnt_range[j])
        out |= {"axis": _words(model.jnt_axis[j]), "ref": _words([model.qpos0[model.jnt_qposadr[j]]])}
        if not _disabled(model, Disable.mjDSBL_SPRING):
            out |= {
                "stiffness": _words([model.jnt_stiffness[j], *model.jnt_stiffnesspoly[j]]),
                "springref": _words([model.qpos_spring[model.jnt_qposadr[j]]]),
            }
    return out


def _disabled(model: mujoco.MjModel, what: mujoco.mjtDisableBit) -> bool:
    return bool(model.opt.disableflags & what)


def _words(values: Iterable[float]) -> str:
    return " ".join(repr(float(value)) for value in values)
