"""What an MJCF file holds beside its tree of bodies and joints: forces that the balance of a tree knows nothing of."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

import mujoco
import numpy as np

from mjfriction.errors import SimulationError
from mjfriction.sim.spec import BY_JOINT, COUPLES, nameless

INSTEAD = "take it out of the model, and state {} at the joints"
HELD = (mujoco.mjtEq.mjEQ_CONNECT, mujoco.mjtEq.mjEQ_WELD)


@dataclass(frozen=True)
class Beside:
    """An element of a model file, in words, the ``joints`` whose motion it acts on, and what to do ``instead``.

    One that needs all of them (``together``) is gone with the first joint that a robot file leaves out.  An equality
    ``couples`` them.
    """

    what: str
    joints: frozenset[str]
    instead: str
    together: bool = False
    couples: bool = False

    def acts_on(self, listed: Collection[str]) -> frozenset[str]:
        """Return those of the ``listed`` joints that it acts on."""
        acts = not self.together or self.joints <= set(listed)
        return self.joints & set(listed) if acts else frozenset()


def beside_the_tree(path: Path) -> tuple[Beside, ...]:
    """Return the elements of an MJCF file that make forces but are no bodies, joints or actuators.

    These are active equalities, tendons with a force of their own, gravity compensation, fluids, and springs that
    yield.  Raises :class:`SimulationError` when MuJoCo cannot read the file.
    """
    try:
        spec = mujoco.MjSpec.from_file(str(path))
    except ValueError as error:
        raise SimulationError(f"{path}: MuJoCo cannot read it: {' '.join(str(error).split())}") from None
    for i, joint in enumerate(spec.joints):
        joint.name = joint.name or nameless(i)
    return (*_equalities(spec), *_tendons(spec), *_compensations(spec), *_fluid(spec), *_yielding(spec))


def _equalities(spec: mujoco.MjSpec) -> Iterator[Beside]:
    if spec.option.disableflags & mujoco.mjtDisableBit.mjDSBL_EQUALITY:
        return
    for one in spec.equalities:
        if not one.active:
            continue
        names, joints = (one.name1, one.name2), frozenset[str]()
        if one.type in HELD:
            of_site = one.objtype == mujoco.mjtObj.mjOBJ_SITE
            joints = _between(spec.site(name).parent if of_site else spec.body(name) for name in names)
        elif one.type == mujoco.mjtEq.mjEQ_TENDON:
            joints = joints.union(*(_wrapped(spec.tendon(name)) for name in names))
        elif one.type in COUPLES:
            joints = frozenset(names) - {""}
        instead = "leave joints that it couples out of the robot file, or take it out of the model"
        yield Beside(f"the equality{_named(one.name)}", joints, instead, together=one.type in COUPLES, couples=True)


def _tendons(spec: mujoco.MjSpec) -> Iterator[Beside]:
    for one in spec.tendons:
        limited = one.limited != mujoco.mjtLimited.mjLIMITED_FALSE and one.range[0] < one.range[1]
        forces = (*np.atleast_1d(one.stiffness), *np.atleast_1d(one.damping), one.frictionloss, one.armature)
        if limited or np.any(forces):
            yield Beside(f"the tendon{_named(one.name)}", _wrapped(one), INSTEAD.format("its spring or friction"))


def _compensations(spec: mujoco.MjSpec) -> Iterator[Beside]:
    for body in spec.bodies[1:]:
        if body.gravcomp != 0.0:
            instead = "take it out of the model: drives report the efforts by which they hold gravity"
            yield Beside(f"the gravcomp of body{_named(body.name)}", _moving(body), instead)


def _fluid(spec: mujoco.MjSpec) -> Iterator[Beside]:
    option = spec.option
    if option.density != 0.0 or option.viscosity != 0.0 or np.any(option.wind):
        joints = frozenset(joint.name for joint in spec.joints)
        yield Beside("the fluid (density, viscosity or wind)", joints, INSTEAD.format("its drag"))


def _yielding(spec: mujoco.MjSpec) -> Iterator[Beside]:
    for joint in spec.joints:
        if np.any(np.asarray(joint.springyield)) and np.any(np.asarray(joint.stiffness)):
            instead = "take it out of the model, and state it in the robot file as the law maxwell_slip"
            yield Beside(f"the springyield of joint{_named(joint.name)}", frozenset({joint.name}), instead)


def _wrapped(tendon: mujoco.MjsTendon | None) -> frozenset[str]:
    if tendon is None:
        return frozenset()
    path = list(tendon.path)
    along = frozenset(wrap.target.name for wrap in path if wrap.type == BY_JOINT)
    return along | _between(wrap.target.parent for wrap in path if wrap.type != BY_JOINT and wrap.target is not None)


def _between(bodies: Iterable[mujoco.MjsBody | None]) -> frozenset[str]:
    # The joints that move some of the bodies against others: what is within a gripper does not act on its arm.
    moving = [_moving(body) for body in bodies]
    return frozenset.union(*moving) - frozenset.intersection(*moving) if moving else frozenset()


def _moving(body: mujoco.MjsBody | None) -> frozenset[str]:
    # The joints that move a body.
    if body is None:
        return frozenset()
    return frozenset(joint.name for joint in body.joints) | _moving(body.parent)


def _named(name: str) -> str:
    return f" '{name}'" if name else ""
