"""A robot's model file as a MuJoCo spec: the same bodies that the rest of the package reads with Pinocchio."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import mujoco
import numpy as np

from mjfriction.errors import SimulationError, suggestion
from mjfriction.sim.shapes import leave_out_missing, moves

Spec = mujoco.MjSpec
BY_JOINT = mujoco.mjtWrap.mjWRAP_JOINT
COUPLES = (mujoco.mjtEq.mjEQ_JOINT, mujoco.mjtEq.mjEQ_TENDON)
NO_MASS = 1e-12  # kg and kg·m²
DIGITS = 1e-5  # share of a body's largest moment that the rounding of all three to six digits may come to
ROUNDED = 1e-4  # share of a body's largest moment of inertia that counts as rounding


@dataclass(frozen=True)
class PointLoad:
    """A point mass held by the robot.

    ``mass`` is in kg, ``com`` is its place in the parent body's frame (m), and ``parent`` is the name of that body or
    of the joint that moves it.
    """

    mass: float
    com: tuple[float, float, float]
    parent: str


@dataclass(frozen=True)
class LinkMass:
    """A link's mass (kg), centre of mass (m) and moments of inertia about it: xx, yy, zz, xy, xz, yz (kg·m²).

    The centre of mass is measured from the link's joint along the body's axes.
    """

    mass: float
    com: tuple[float, float, float]
    inertia: tuple[float, float, float, float, float, float]


def read_spec(
    path: Path,
    joints: Sequence[str],
    *,
    gravity: Sequence[float] | None = None,
    loads: Mapping[str, PointLoad] | None = None,
    link_inertia: Mapping[str, LinkMass] | None = None,
    link_scale: Mapping[str, float] | None = None,
    link_shift: Mapping[str, Sequence[float]] | None = None,
    rotor_inertia: Mapping[str, float] | None = None,
) -> mujoco.MjSpec:
    """Read a URDF or MJCF file and build the robot's own data into it.

    Joints that are not in ``joints`` are held where the file has them (at zero, or an MJCF's ``ref``), and keyframes,
    which state those too, are dropped.  ``gravity`` (m/s²) replaces the model's own.  ``loads`` are masses held, each
    added as a body of that name.  ``link_inertia`` replaces the model's inertia of the link that a
    joint moves, ``link_shift`` moves that link's own centre of mass (m, in the body's frame), and ``link_scale``
    multiplies its mass and inertia, including its loads.  ``rotor_inertia`` (kg·m² or kg at the joint) is added as
    armature.  Shapes of a URDF are left out, since they do not affect the motion, and so are those of an MJCF whose
    mesh files are missing.  Joints without a name get that of :func:`nameless`.

    Raises :class:`SimulationError` when the file cannot be read or a joint or body does not exist.
    """
    spec = _read(path)
    spec.compiler.fusestatic = False
    if gravity is not None:
        spec.option.gravity = np.array(gravity)
        spec.option.disableflags &= ~int(mujoco.mjtDisableBit.mjDSBL_GRAVITY)
    names = [joint.name for joint in spec.joints]
    for name in joints:
        if name not in names:
            raise SimulationError(f"{path}: there is no joint '{name}' in the model{suggestion(name, names)}")
    # Find the bodies that hold loads now: a load may name a held joint, and held joints are deleted next.
    holders = {name: _link(spec, load.parent, path, name) for name, load in (loads or {}).items()}
    _hold(spec, set(names) - set(joints))
    _make_sound(spec)
    for key, named in (("link_inertia", link_inertia), ("link_shift", link_shift), ("link_scale", link_scale)):
        for name in named or {}:
            if name not in names:
                raise SimulationError(f"{path}: {key}: there is no joint '{name}'{suggestion(name, names)}")
    for name, link in (link_inertia or {}).items():
        _put_in_place(spec.joint(name), link)
    for name, shift in (link_shift or {}).items():
        _shift_centre(spec, name, np.array(shift))
    for name, load in (loads or {}).items():
        # Keep the body's frame at the parent's and set `ipos`: where `ipos` is left out, a spec copies it from `pos`.
        holders[name].add_body(name=name, ipos=load.com, mass=load.mass, inertia=[0.0] * 3, explicitinertial=True)
    for name, scale in (link_scale or {}).items():
        _scale_link(spec.joint(name), scale, path)
    for name, inertia in (rotor_inertia or {}).items():
        spec.joint(name).armature += inertia
    if all(joint.armature > 0.0 for joint in spec.joints):
        # Behind a rotor a link may have no mass, but MuJoCo requires some.
        spec.compiler.boundmass = max(spec.compiler.boundmass, NO_MASS)
        spec.compiler.boundinertia = max(spec.compiler.boundinertia, NO_MASS)
    return spec


def nameless(number: int) -> str:
    """Return the name that the package gives a joint without one, by its number in the file."""
    return f"joint {number}"


def drop_actuators(spec: mujoco.MjSpec) -> None:
    """Remove a model's own actuators from a spec, in place, and what its keyframes say of them: efforts act on the
    joints directly.
    """
    for actuator in list(spec.actuators):
        spec.delete(actuator)
    for key in spec.keys:
        key.ctrl = key.act = []


def compiled(spec: mujoco.MjSpec) -> mujoco.MjModel:
    """Compile a spec into a model; raises :class:`SimulationError` with MuJoCo's message where it cannot."""
    try:
        return spec.compile()
    except ValueError as error:
        raise SimulationError(f"MuJoCo cannot compile the model: {' '.join(str(error).split())}") from None


def _link(spec: mujoco.MjSpec, name: str, path: Path, load: str) -> mujoco.MjsBody:
    # Find a body by its own name, or by the name of the joint that moves it.
    for link in (spec.body(name), *(joint.parent for joint in spec.joints if joint.name == name)):
        if link is not None:
            return link
    names = [one.name for one in (*spec.bodies, *spec.joints) if one.name]
    raise SimulationError(f"{path}: {load}: there is no body or joint '{name}' in the model{suggestion(name, names)}")


def _hold(spec: mujoco.MjSpec, names: set[str]) -> None:
    # Delete what names these joints too, since it would stop the compiler: tendons along them, the equalities and
    # actuators of both, and keyframes, which state all joints and actuators.
    if not names:
        return
    along = [one for one in spec.tendons if names & {wrap.target.name for wrap in one.path if wrap.type == BY_JOINT}]
    gone = names | {tendon.name for tendon in along}
    coupled = [one for one in spec.equalities if one.type in COUPLES and gone & {one.name1, one.name2}]
    driven = [one for one in spec.actuators if one.target in gone]
    held = [one for one in spec.joints if one.name in names]
    for element in (*spec.keys, *coupled, *driven, *along, *held):
        spec.delete(element)


def _make_sound(spec: mujoco.MjSpec) -> None:
    # MuJoCo refuses moments of inertia that no body has: their matrix must be positive, and none of the three may be
    # larger than the other two together. Of a body that no joint moves they have no effect, and what rounding makes
    # wrong lacks next to nothing.
    for body in spec.bodies[1:]:
        if not np.all(np.isfinite(body.fullinertia)):
            continue
        least, middle, most = np.linalg.eigvalsh(_matrix(body.fullinertia))
        lacking = NO_MASS + max(-least, most - middle - least)
        if lacking <= 0.0:
            continue
        if lacking < NO_MASS + ROUNDED * most:
            body.fullinertia = np.asarray(body.fullinertia) + lacking * np.repeat([1.0, 0.0], 3)
        elif not moves(body):
            body.fullinertia = np.full(6, np.nan)


def leave_room_for_digits(spec: mujoco.MjSpec) -> None:
    """Keep the moments of inertia of a spec's bodies such as a body can have when written with six digits, in place."""
    for body in spec.bodies[1:]:
        full = bool(np.all(np.isfinite(body.fullinertia)))
        own = np.linalg.eigvalsh(_matrix(body.fullinertia)) if full else np.sort(np.asarray(body.inertia))
        least, middle, most = own.tolist()
        lacking = DIGITS * most - (least + middle - most)
        if lacking > 0.0 and full:
            body.fullinertia = np.asarray(body.fullinertia) + lacking * np.repeat([1.0, 0.0], 3)
        elif lacking > 0.0:
            body.inertia = np.asarray(body.inertia) + lacking


def _matrix(moments: np.ndarray) -> np.ndarray:
    xx, yy, zz, xy, xz, yz = moments
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def _put_in_place(joint: mujoco.MjsJoint, link: LinkMass) -> None:
    # The joint's own body gets the whole mass; the bodies fixed to it get none.
    for body in _rigid_with(joint.parent):
        body.explicitinertial = True
        body.mass, body.inertia, body.fullinertia = 0.0, np.zeros(3), np.full(6, np.nan)
    body = joint.parent
    body.mass, body.fullinertia = link.mass, np.array(link.inertia)
    body.ipos, body.iquat = np.array(link.com) + np.asarray(joint.pos), np.array([1.0, 0.0, 0.0, 0.0])


def _scale_link(joint: mujoco.MjsJoint, scale: float, path: Path) -> None:
    for body in _rigid_with(joint.parent):
        if body.geoms and not body.explicitinertial:
            raise SimulationError(
                f"{path}: link_scale of '{joint.name}': body '{body.name}' has no inertial element but shapes to "
                "compute it from; write its <inertial> into the model"
            )
        body.mass *= scale
        body.inertia = scale * np.asarray(body.inertia)
        body.fullinertia = scale * np.asarray(body.fullinertia)


def _shift_centre(spec: mujoco.MjSpec, joint: str, shift: np.ndarray) -> None:
    # Bodies that all move by as much keep their moments of inertia about the centre that they have in common.
    for body, turned in zip(_rigid_with(spec.joint(joint).parent), _turned(spec, joint), strict=True):
        body.ipos = np.asarray(body.ipos) + turned.T @ shift


def _turned(spec: mujoco.MjSpec, joint: str) -> list[np.ndarray]:
    # How the bodies of a joint's link are turned against the link.  Some that move may have no mass yet.
    if len(_rigid_with(spec.joint(joint).parent)) == 1:
        return [np.eye(3)]
    apart = spec.copy()
    apart.compiler.boundmass = apart.compiler.boundinertia = NO_MASS
    data = mujoco.MjData(compiled(apart))
    mujoco.mj_kinematics(data.model, data)
    link, *others = (data.xmat[body.id].reshape(3, 3) for body in _rigid_with(apart.joint(joint).parent))
    return [np.eye(3), *(link.T @ other for other in others)]


def _rigid_with(body: mujoco.MjsBody) -> list[mujoco.MjsBody]:
    found = [body]
    for child in body.bodies:
        if not child.joints:
            found += _rigid_with(child)
    return found


def _read(path: Path) -> mujoco.MjSpec:
    try:
        text = path.read_text(encoding="utf-8")
        root = ET.fromstring(text)
        if root.tag != "robot":
            spec = mujoco.MjSpec.from_file(str(path))
            # The spec may later be written elsewhere, so the folders of its meshes and textures become absolute.
            spec.meshdir = str((path.parent / spec.meshdir).resolve())
            spec.texturedir = str((path.parent / spec.texturedir).resolve())
            leave_out_missing(spec, path)
            for i, joint in enumerate(spec.joints):
                joint.name = joint.name or nameless(i)
            _weigh(spec)
            return spec
        for link in root.iter("link"):
            for shape in [*link.findall("visual"), *link.findall("collision")]:
                link.remove(shape)
        for limit in root.iter("limit"):
            # An empty range means that no limit was intended.  MuJoCo ignores it too, but warns each time.
            if float(limit.get("lower", 0.0)) >= float(limit.get("upper", 0.0)):
                limit.attrib.pop("lower", None)
                limit.attrib.pop("upper", None)
        return mujoco.MjSpec.from_string(ET.tostring(root, encoding="unicode"))
    except (OSError, ET.ParseError, ValueError) as error:
        raise SimulationError(f"{path}: MuJoCo cannot read it: {' '.join(str(error).split())}") from None


def _weigh(spec: mujoco.MjSpec) -> None:
    # Write inertias computed from shapes out explicitly, so that they can be moved and scaled like any other.
    spec.compiler.fusestatic = False
    by_shape = spec.compiler.inertiafromgeom == mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_TRUE
    weighed = [body for body in spec.bodies if body.parent and body.geoms and (by_shape or not body.explicitinertial)]
    if not weighed:
        return
    model = spec.compile()
    spec.compiler.inertiafromgeom = mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_AUTO
    for body in weighed:
        if body.id > 0:
            body.explicitinertial, body.fullinertia = True, np.full(6, np.nan)
            body.mass, body.inertia = float(model.body_mass[body.id]), model.body_inertia[body.id].copy()
            body.ipos, body.iquat = model.body_ipos[body.id].copy(), model.body_iquat[body.id].copy()
