"""A robot's rigid bodies, read from URDF or MJCF."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pinocchio as pin

from mjfriction.body.inertia import RigidLink
from mjfriction.body.model_file import Unread, parse, slides, unread
from mjfriction.errors import RobotError, suggestion
from mjfriction.laws.law import Floats

NO_LIMIT = 1e3  # rad/s or m/s; a stated top speed of at least this counts as no limit


@dataclass(frozen=True)
class Load:
    """A rigid mass held by the robot: kg, centre of mass in the parent link's frame (m), and the name of that
    link or of the joint that moves it.
    """

    mass: float
    com: tuple[float, float, float]
    parent: str


@dataclass(frozen=True)
class Body:
    """A tree of rigid bodies on a fixed base, with the requested joints in the requested order.

    ``links`` names the bodies in the order of the regressor's columns; ``sliding`` (joints,) is True for prismatic
    joints; ``damping`` and ``dry_friction`` (joints,) are the model file's own values; ``lower`` and ``upper`` are its
    position limits and ``top_speed`` its velocity limits, infinite where it states none.  ``bent_damping``
    (joints,) is True where its damping has terms of higher order.  ``spring`` (joints, 4) is what the model's own
    springs demand of the drives, as polynomials in position, constant first.
    """

    joints: tuple[str, ...]
    links: tuple[str, ...]
    sliding: tuple[bool, ...]
    damping: Floats
    dry_friction: Floats
    lower: Floats
    upper: Floats
    top_speed: Floats
    bent_damping: tuple[bool, ...]
    spring: Floats
    gravity: Floats
    model: pin.Model
    columns: tuple[int, ...]  # index of each requested joint in the model's velocity vector

    @property
    def armature(self) -> Floats:
        """The rotors' inertia at the joints, (joints,): kg·m², or kg on sliding joints."""
        return np.array(self.model.armature)[list(self.columns)]

    def holding(self, load: Load) -> Body:
        """Return the bodies with an additional mass; :class:`RobotError` if its parent is not one of them."""
        model = pin.Model(self.model)
        _append(model, load)
        return replace(self, model=model)

    def weightless(self) -> Body:
        """Return the same joints with all masses and inertias removed, including the rotors."""
        model = pin.Model(self.model)
        for i in range(1, model.njoints):
            model.inertias[i] = pin.Inertia.Zero()
        model.armature = np.zeros(model.nv)
        return replace(self, model=model)

    def on_link(self, parent: str, point: Floats, link: str) -> Floats:
        """Return a ``point`` (m) of a payload's ``parent`` frame in the frame of the ``link`` it is fixed to, (3,)."""
        held, own = _link_frame(self.model, parent), _link_frame(self.model, link)
        if held is None or own is None or held.parentJoint != own.parentJoint:
            raise RobotError(f"'{parent}' is not fixed to link '{link}' of the model")
        return np.asarray(own.placement.actInv(held.placement.act(np.asarray(point, dtype=np.float64))))

    def link_holding(self, parent: str) -> str:
        """Return the name of the joint that moves the link that a payload's ``parent`` is, or is fixed to."""
        found = _link_frame(self.model, parent)
        if found is None:
            raise RobotError(f"the model has neither a link nor a joint '{parent}'")
        return str(self.model.names[found.parentJoint])


def load_body(
    path: Path,
    joints: Sequence[str],
    *,
    gravity: Sequence[float] | None = None,
    payload: Load | None = None,
    link_inertia: Mapping[str, RigidLink] | None = None,
    link_scale: Mapping[str, float] | None = None,
    link_shift: Mapping[str, Sequence[float]] | None = None,
    rotor_inertia: Sequence[float] | None = None,
    text: str | None = None,
) -> Body:
    """Read a model file and build the robot's rigid bodies.

    ``text`` is an MJCF in the expanded form that :func:`~mjfriction.sim.plain_tree.plain_tree` writes; it is required
    for an MJCF.

    Joints of the model that are not requested (a gripper's fingers) are locked where the file has them: at their zero,
    or an MJCF's ``ref``.  ``gravity`` (m/s²) replaces the model's own; ``link_inertia`` replaces a link's mass and
    inertia; ``link_scale`` multiplies the mass and inertia of the link that a joint moves, including its payload;
    ``link_shift`` moves its centre of mass (m, in the link's frame); ``rotor_inertia`` (kg·m² or kg at the joint, per
    requested joint) is added to the model's.

    Raises :class:`RobotError` if the file is missing or does not parse, if a joint is unknown or has more than one
    axis, if the payload's parent is unknown, if a link is named by a joint that is not the last of its body, or if
    nothing that moves has a mass.
    """
    full, own_gravity = parse(path, text)
    known = [name for name in full.names if name != "universe"]
    for joint in joints:
        if joint not in known:
            raise RobotError(
                f"{path}: there is no joint '{joint}' in the model{suggestion(joint, known)} "
                f"Its joints are {', '.join(known)}"
            )
    locked = [full.getJointId(name) for name in known if name not in joints]
    _tell_apart(full, known if locked else ())
    stated = unread(text)
    _check_last(path, "link_inertia", link_inertia or (), stated)
    _check_last(path, "link_shift", link_shift or (), stated)
    _check_last(path, "link_scale", link_scale or (), stated)
    _check_last(path, "payload", (payload.parent,) if payload else (), stated)
    model = pin.buildReducedModel(full, locked, _placed(full, stated)) if locked else full
    for joint in joints:
        axes = model.joints[model.getJointId(joint)].nv
        if axes != 1:
            raise RobotError(f"{path}: joint '{joint}' has {axes} axes; only hinges and slides can carry friction")
    columns = tuple(int(model.joints[model.getJointId(joint)].idx_v) for joint in joints)
    model.gravity.linear = np.array(own_gravity if gravity is None else gravity, dtype=np.float64)
    for joint, link in (link_inertia or {}).items():
        model.inertias[_index(model, joint, "link_inertia", path)] = link.pinocchio()
    for joint, shift in (link_shift or {}).items():
        index = _index(model, joint, "link_shift", path)
        inertia = model.inertias[index]
        model.inertias[index] = pin.Inertia(inertia.mass, inertia.lever + np.array(shift), inertia.inertia)
    if payload is not None:
        try:
            _append(model, payload)
        except RobotError as error:
            raise RobotError(f"{path}: payload {error}") from None
    for joint, scale in (link_scale or {}).items():
        index = _index(model, joint, "link_scale", path)
        inertia = model.inertias[index]
        model.inertias[index] = pin.Inertia(scale * inertia.mass, inertia.lever, scale * inertia.inertia)
    if rotor_inertia is not None:
        armature = model.armature.copy()
        armature[list(columns)] += np.asarray(rotor_inertia)
        model.armature = armature
    if not any(inertia.mass > 0.0 for inertia in list(model.inertias)[1:]) and not np.any(model.armature):
        raise RobotError(
            f"{path}: no link that moves has a mass, so that no effort can be predicted; state the links' inertias in "
            "the model, as CAD exports often leave them out"
        )
    order = list(columns)
    lower, upper = _limits(model, joints, stated)
    return Body(
        joints=tuple(joints),
        links=tuple(str(name) for name in list(model.names)[1:]),
        sliding=tuple(slides(model.joints[model.getJointId(joint)]) for joint in joints),
        damping=np.array(model.damping)[order],
        dry_friction=np.array(model.upperDryFrictionLimit)[order],
        lower=lower,
        upper=upper,
        top_speed=_top_speeds(model, columns),
        bent_damping=tuple(joint in stated and stated[joint].bent_damping for joint in joints),
        spring=np.array([stated[joint].spring if joint in stated else np.zeros(4) for joint in joints]),
        gravity=np.array(model.gravity.linear),
        model=model,
        columns=columns,
    )


def _check_last(path: Path, key: str, named: Collection[str], stated: Mapping[str, Unread]) -> None:
    # Of several joints of one body, the last one moves its mass; the others move nothing that could be changed.
    for joint in named:
        last = stated[joint].before if joint in stated else None
        if last is not None:
            raise RobotError(
                f"{path}: {key}: joint '{joint}' shares its body with joint '{last}'; name '{last}' instead"
            )


def _placed(model: pin.Model, stated: Mapping[str, Unread]) -> Floats:
    # The neutral configuration, with the joints that have a reference at it.
    q = np.array(pin.neutral(model))
    for name, own in stated.items():
        if own.reference != 0.0:
            entry = model.joints[model.getJointId(name)]
            q[entry.idx_q : entry.idx_q + entry.nq] = _as_configuration(entry, np.array([own.reference]))[0]
    return q


def _as_configuration(entry: pin.JointModel, position: Floats) -> Floats:
    # Positions (n,) of a joint of one axis as its part of the configuration vectors, (n, nq): Pinocchio stores a joint
    # without limits as cosine and sine.
    return np.column_stack([position] if entry.nq == 1 else [np.cos(position), np.sin(position)])


def _tell_apart(model: pin.Model, joints: Collection[str]) -> None:
    # Pinocchio locks joints, and places the others anew, by the names of their frames.  A link may have the same name
    # as a joint, so rename such a link; it is still found by the name of its joint.
    for frame in model.frames:
        if frame.type == pin.FrameType.BODY and frame.name in joints:
            frame.name = f"{frame.name} link"


def _index(model: pin.Model, joint: str, key: str, path: Path) -> int:
    if joint not in list(model.names)[1:]:
        raise RobotError(f"{path}: {key}: there is no joint '{joint}'{suggestion(joint, model.names)}")
    return int(model.getJointId(joint))


def single_axis_joints(path: Path, text: str | None = None) -> tuple[str, ...]:
    """Return the hinges and slides of a model file, in its order; ``text`` and errors as in :func:`load_body`."""
    model, _ = parse(path, text)
    return tuple(
        str(name) for name, joint in zip(list(model.names)[1:], list(model.joints)[1:], strict=True) if joint.nv == 1
    )


def _top_speeds(model: pin.Model, columns: Sequence[int]) -> Floats:
    stated = np.array(model.velocityLimit)[list(columns)]
    return np.where((stated > 0.0) & (stated < NO_LIMIT), stated, np.inf)


def configuration(body: Body, position: Floats) -> Floats:
    """Return joint positions (n, joints) as the model's configuration vectors (n, nq)."""
    model = body.model
    q = np.tile(pin.neutral(model), (position.shape[0], 1))
    for i, joint in enumerate(body.joints):
        entry = model.joints[model.getJointId(joint)]
        q[:, entry.idx_q : entry.idx_q + entry.nq] = _as_configuration(entry, position[:, i])
    return q


def in_model_order(body: Body, values: Floats) -> Floats:
    """Return joint velocities or accelerations (n, joints) in the order of the model's velocity vector (n, nv)."""
    out = np.zeros((values.shape[0], body.model.nv))
    out[:, list(body.columns)] = values
    return out


def _append(model: pin.Model, load: Load) -> None:
    frame = _link_frame(model, load.parent)
    if frame is None:
        names = [frame.name for frame in model.frames]
        raise RobotError(
            f"parent '{load.parent}' is no link of the model, nor a joint of it{suggestion(load.parent, names)}"
        )
    point = pin.Inertia(load.mass, np.array(load.com), np.zeros((3, 3)))
    model.appendBodyToJoint(frame.parentJoint, point, frame.placement)


def _link_frame(model: pin.Model, name: str) -> pin.Frame | None:
    # The frame of a link, by its own name or by that of the joint that moves it, even if that joint is locked.
    links = [frame for frame in model.frames if frame.type == pin.FrameType.BODY]
    named = [frame for frame in links if frame.name == name]
    moved = [frame for frame in links if model.frames[frame.parentFrame].name == name]
    return next(iter(named + moved), None)


def _limits(model: pin.Model, joints: Sequence[str], stated: Mapping[str, Unread]) -> tuple[Floats, Floats]:
    # An empty range means that a URDF states no limits; MuJoCo reads it the same way.  Pinocchio counts the range of a
    # joint with a reference from that, but not its position.
    lower, upper = np.full(len(joints), -np.inf), np.full(len(joints), np.inf)
    for i, joint in enumerate(joints):
        entry = model.joints[model.getJointId(joint)]
        if entry.nq == 1 and model.lowerPositionLimit[entry.idx_q] < model.upperPositionLimit[entry.idx_q]:
            reference = stated[joint].reference if joint in stated else 0.0
            lower[i] = model.lowerPositionLimit[entry.idx_q] + reference
            upper[i] = model.upperPositionLimit[entry.idx_q] + reference
    return lower, upper
