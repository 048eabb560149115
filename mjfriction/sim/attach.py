"""Attach friction laws to the joints of a MuJoCo model."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import mujoco
import numpy as np

from mjfriction.errors import SimulationError, suggestion
from mjfriction.laws.ambient import LOAD
from mjfriction.laws.friction import Friction
from mjfriction.laws.law import Floats
from mjfriction.sim import block as at
from mjfriction.sim.spec import compiled

Laws = Mapping[str, Friction | Sequence[Friction]]
ONE_DOF = frozenset({int(mujoco.mjtJoint.mjJNT_HINGE), int(mujoco.mjtJoint.mjJNT_SLIDE)})


@dataclass(frozen=True)
class Term:
    """One law on one joint; ``rubbing`` is the joint's index among those with friction."""

    rubbing: int
    friction: Friction


def attach(spec: mujoco.MjSpec, laws: Laws, *, keep_native: bool = False) -> mujoco.MjModel:
    """Compile a model whose joints carry friction laws; the spec itself is not changed.

    ``laws`` maps names of hinge or slide joints to one law or several, which add up.  The model holds the laws in a
    custom numeric and the simulation their states in user data, so copies, saved files and states carry them.  A
    joint's own ``damping`` and ``frictionloss`` are replaced, unless ``keep_native``.  Step it inside
    :func:`~mjfriction.sim.callback.friction_active`.

    Raises :class:`SimulationError` for what is no spec or no law, a joint that is not there or is a ball or free joint,
    an empty mapping, a model that already carries friction or cannot be compiled, the integrator RK4, whose stages have
    no bristle states between them, or disabled actuation, without which MuJoCo calls no callback.
    """
    if not isinstance(spec, mujoco.MjSpec):
        raise SimulationError(
            f"friction is attached to an MjSpec, not to {type(spec).__name__}; read the model's file with "
            "mujoco.MjSpec.from_file(path)"
        )
    spec = spec.copy()
    if not laws:
        raise SimulationError("no joint was given a friction law; give at least one")
    for name, own in laws.items():
        if not isinstance(own, Friction | Sequence) or not all(isinstance(one, Friction) for one in _several(own)):
            raise SimulationError(
                f"joint '{name}': {own!r} is no friction law; give one, or a list, each made with "
                "mjfriction.friction(name, {parameter: value})"
            )
        if not _several(own):
            raise SimulationError(
                f"joint '{name}': its list of friction laws is empty; give one or leave the joint out"
            )
    if any(numeric.name == at.NUMERIC_NAME for numeric in spec.numerics):
        raise SimulationError("the model already carries friction; attach to the model it was made from")
    if not keep_native:
        for joint in spec.joints:
            if joint.name in laws:
                joint.damping = np.zeros_like(joint.damping)
                joint.frictionloss = 0.0
    plain = compiled(spec)
    refuse_integrator(plain)
    for name in laws:
        dof_of(plain, name)
    own = spec.nuserdata
    block = build_block(plain, laws, max(own, 0))
    spec.add_numeric(name=at.NUMERIC_NAME, data=block, size=block.size)
    touched, rubbing, states = (int(block[i]) for i in (at.H_TOUCHED, at.H_RUBBING, at.H_STATES))
    spec.nuserdata = max(own, 0) + at.room_needed(touched, rubbing, states)
    return compiled(spec)


def rewrite(model: mujoco.MjModel, laws: Laws) -> None:
    """Replace the laws of a loaded model that was compiled with friction on the same joints.

    Raises :class:`SimulationError` when the model has no room for them: it was compiled without friction, or the new
    laws have other states or more parameters.
    """
    model.numeric_data[numeric_slice(model)] = candidate_blocks(model, [laws])[0]


def candidate_blocks(model: mujoco.MjModel, candidates: Sequence[Laws]) -> Floats:
    """Return the friction blocks of many sets of laws for one model, (candidates, numbers).

    Raises :class:`SimulationError` where a set does not fit into the model; see :func:`rewrite`.
    """
    old = model.numeric_data[numeric_slice(model)]
    blocks = []
    for laws in candidates:
        block = build_block(model, laws, int(old[at.H_BASE]))
        if block.size != old.size or layout_of(block) != layout_of(old):
            raise SimulationError(
                f"the model has room for {old.size} numbers and {int(old[at.H_STATES])} states of friction on its "
                f"joints, these laws take {block.size} and {int(block[at.H_STATES])} or stand on others; attach them "
                "to the MjSpec and compile anew"
            )
        blocks.append(block)
    return np.array(blocks)


def layout_of(block: Floats) -> tuple[list[float], list[list[float]]]:
    """Return what two blocks must share to fit one model: the dofs, and the places of every law's states and values."""
    table, count = int(block[at.H_TERM_TABLE]), int(block[at.H_TERMS])
    rows = block[table : table + count * at.TERM_ROW].reshape(count, at.TERM_ROW)
    return block[at.HEADER : table].tolist(), rows.tolist()


def numeric_slice(model: mujoco.MjModel) -> slice:
    """Return the slice of ``numeric_data`` that is the friction block; raises :class:`SimulationError` without one."""
    number = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_NUMERIC, at.NUMERIC_NAME)
    if number < 0:
        raise SimulationError(
            "the model carries no friction and was compiled without room for it; attach laws to its MjSpec"
        )
    start = int(model.numeric_adr[number])
    if model.numeric_data[start + at.H_VERSION] != at.VERSION:
        raise SimulationError("the model's friction was written by another release; attach the laws to its MjSpec anew")
    return slice(start, start + int(model.numeric_size[number]))


def refuse_integrator(model: mujoco.MjModel) -> None:
    """Raise :class:`SimulationError` for RK4 and for disabled actuation, under which MuJoCo calls no callback."""
    if model.opt.integrator == mujoco.mjtIntegrator.mjINT_RK4:
        raise SimulationError(
            "integrator RK4: its stages lie inside a step, where bristles have no state; choose Euler, implicit, "
            "implicitfast or discrete"
        )
    if model.opt.disableflags & mujoco.mjtDisableBit.mjDSBL_ACTUATION:
        raise SimulationError("the flag actuation is disabled, and MuJoCo then calls no callback; enable it")


def dof_of(model: mujoco.MjModel, joint: str) -> int:
    """Return the dof of a hinge or slide joint; raises :class:`SimulationError` for any other name."""
    number = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_JOINT, joint)
    names = [model.joint(i).name for i in range(model.njnt)]
    if number < 0:
        raise SimulationError(
            f"joint '{joint}' is not in the model{suggestion(joint, names)} It has {', '.join(names) or 'no joints'}"
        )
    if int(model.jnt_type[number]) not in ONE_DOF:
        kind = mujoco.mjtJoint(model.jnt_type[number]).name.removeprefix("mjJNT_").lower()
        raise SimulationError(f"joint '{joint}' is a {kind} joint; friction laws act on hinge and slide joints")
    return int(model.jnt_dofadr[number])


def build_block(model: mujoco.MjModel, laws: Laws, base: int) -> Floats:
    """Return the model's friction block as :mod:`mjfriction.sim.block` lays it out."""
    rubbing = sorted((dof_of(model, name), name) for name in laws)
    dofs = [dof for dof, _ in rubbing]
    trees = {int(model.dof_treeid[dof]) for dof in dofs}
    others = [i for i in range(model.nv) if int(model.dof_treeid[i]) in trees and i not in dofs]
    touched = [*others, *dofs]
    local = np.full(model.nv, -1.0)
    local[touched] = np.arange(len(touched))
    terms = [Term(i, own) for i, (_, name) in enumerate(rubbing) for own in _several(laws[name])]
    # An actuator at its limit has no velocity gain, and only the step knows whether it is there.  So the gains of all
    # actuators are ignored where any can be limited or disabled.
    limited = np.any(model.actuator_forcelimited) or np.any(model.jnt_actfrclimited) or model.opt.disableactuator
    one_output = model.nout == model.nu == model.nactuator and not limited
    table = at.HEADER + len(touched) + model.nv + len(dofs)
    head = np.zeros(at.HEADER)
    head[at.H_MAGIC], head[at.H_VERSION], head[at.H_BASE] = at.MAGIC, at.VERSION, base
    head[at.H_DOFS], head[at.H_PLACES], head[at.H_BODIES] = model.nv, model.nq, model.nbody
    head[at.H_TOUCHED], head[at.H_RUBBING] = len(touched), len(dofs)
    head[at.H_TERMS], head[at.H_STATES] = len(terms), sum(term.friction.state_count for term in terms)
    head[at.H_LOAD] = any(_reads_load(term.friction) for term in terms)
    head[at.H_ACTUATORS], head[at.H_DRIVEN] = model.nu if one_output else 0, model.nactuator > 0
    head[at.H_FORESEEN] = _all_foreseen(model, one_output=one_output)
    head[at.H_DOF_LIST] = at.HEADER
    head[at.H_LOCAL] = at.HEADER + len(touched)
    head[at.H_POSITIONS] = at.HEADER + len(touched) + model.nv
    head[at.H_TERM_TABLE] = table
    rows = np.zeros((len(terms), at.TERM_ROW))
    where, state = table + rows.size, 0
    for row, term in zip(rows, terms, strict=True):
        count, size = term.friction.state_count, term.friction.packed.size
        row[:] = (term.rubbing, state, count, where, size)
        where, state = where + size, state + count
    joints = [mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_JOINT, name) for _, name in rubbing]
    positions = model.jnt_qposadr[joints]
    values = [term.friction.packed for term in terms]
    return np.concatenate([head, touched, local, positions, rows.ravel(), *values])


def _all_foreseen(model: mujoco.MjModel, *, one_output: bool) -> bool:
    # Whether the step predicts all that MuJoCo's integrators treat implicitly.
    left_out = [model.opt.density, model.opt.viscosity, model.dof_dampingpoly]
    left_out += [model.tendon_damping, model.tendon_dampingpoly, model.actuator_damping, model.actuator_dampingpoly]
    gains = (model.actuator_biastype == mujoco.mjtBias.mjBIAS_AFFINE) & (model.actuator_biasprm[:, 2] != 0.0)
    of_joints = bool(np.all(model.actuator_trntype[gains] == mujoco.mjtTrn.mjTRN_JOINT))
    return not any(np.any(own) for own in left_out) and (not np.any(gains) or (one_output and of_joints))


def _several(own: Friction | Sequence[Friction]) -> tuple[Friction, ...]:
    return (own,) if isinstance(own, Friction) else tuple(own)


def _reads_load(own: Friction) -> bool:
    return LOAD in own.law.reads or own.level.per_load != 0.0
