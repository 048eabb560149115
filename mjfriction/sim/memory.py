"""The memory a step works in, as named views: the model's block, the simulation's user data, MuJoCo's stack."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mjfriction.laws.ambient import AMBIENT_SIZE
from mjfriction.laws.law import Floats, kernel
from mjfriction.laws.window import integers_at, matrix_at, window, window_at
from mjfriction.sim import block as at
from mjfriction.sim.layout import Field
from mjfriction.sim.native import offset_of, stack_numbers, word_at

Integers = NDArray[np.int32]

# Plain integers, which compiled code takes as constants.
F_NNUMERIC, F_TIMESTEP, F_INTEGRATOR, F_DISABLE = (
    int(Field.NNUMERIC),
    int(Field.TIMESTEP),
    int(Field.INTEGRATOR),
    int(Field.DISABLEFLAGS),
)
F_NUSERDATA, F_NEFC = int(Field.NUSERDATA), int(Field.NEFC)
F_TIME, F_NUMERIC_ADR, F_NUMERIC_DATA = int(Field.TIME), int(Field.NUMERIC_ADR), int(Field.NUMERIC_DATA)
F_ROWNNZ, F_ROWADR, F_COLIND = int(Field.M_ROWNNZ), int(Field.M_ROWADR), int(Field.M_COLIND)
F_DAMPING, F_ARMATURE = int(Field.DOF_DAMPING), int(Field.DOF_ARMATURE)
F_BIASTYPE, F_BIASPRM = int(Field.ACTUATOR_BIASTYPE), int(Field.ACTUATOR_BIASPRM)
F_QPOS, F_QVEL, F_USERDATA, F_M = int(Field.QPOS), int(Field.QVEL), int(Field.USERDATA), int(Field.M)
F_PASSIVE, F_BIAS, F_APPLIED = int(Field.QFRC_PASSIVE), int(Field.QFRC_BIAS), int(Field.QFRC_APPLIED)
F_XFRC, F_ACTUATOR, F_XIPOS = int(Field.XFRC_APPLIED), int(Field.QFRC_ACTUATOR), int(Field.XIPOS)
F_MOMENT_ROWNNZ, F_MOMENT_ROWADR = int(Field.MOMENT_ROWNNZ), int(Field.MOMENT_ROWADR)
F_MOMENT_COLIND, F_MOMENT = int(Field.MOMENT_COLIND), int(Field.ACTUATOR_MOMENT)


class Block(NamedTuple):
    """The model's block, unpacked; ``terms`` is the address of its table of ``term_count`` rows."""

    address: int
    nv: int
    nq: int
    bodies: int
    touched: int
    rubbing: int
    term_count: int
    states: int
    reads_load: bool
    actuators: int
    driven: bool
    foreseen: bool
    terms: int
    dofs: Floats
    local: Floats
    positions: Floats


class Kept(NamedTuple):
    """The simulation's block: ``stamp`` holds its scalars, the rest are arrays as :mod:`mjfriction.sim.block` says."""

    stamp: Floats
    before: Floats
    predicted: Floats
    unknown: Floats
    moved: Floats
    torque: Floats
    marked: Floats
    load: Floats
    warmth: Floats
    pressure_head: Floats
    pressure_rod: Floats
    z: Floats
    z_next: Floats


class Desk(NamedTuple):
    """Work space on MuJoCo's stack: arrays over touched (n), rubbing (k) and all dofs (nv).

    ``now`` (n,) are the velocities as the step begins; ``start`` (k,) is its tail, the velocities of the rubbing dofs.
    """

    a: Floats
    s: Floats
    j: Floats
    f: Floats
    end_velocity: Floats
    now: Floats
    start: Floats
    v: Floats
    change: Floats
    trial: Floats
    slope: Floats
    v_before: Floats
    torque_before: Floats
    around: Floats
    full: Floats
    near: Floats


@kernel
def numbers(struct: int, field: int, count: int) -> Floats:
    """Return a float64 array field of a struct as a view, (count,)."""
    view: Floats = window_at(word_at(struct + offset_of(field)), count)
    return view


@kernel
def integers(struct: int, field: int, count: int) -> Integers:
    """Return an int32 array field of a struct as a view, (count,)."""
    view: Integers = integers_at(word_at(struct + offset_of(field)), count)
    return view


@kernel
def scalar(struct: int, field: int) -> float:
    """Return a float64 that is stored in the struct itself."""
    return float(window_at(struct + offset_of(field), 1)[0])


@kernel
def flag(struct: int, field: int) -> int:
    """Return an int32 that is stored in the struct itself."""
    return int(integers_at(struct + offset_of(field), 1)[0])


@kernel
def find_block(model: int) -> int:
    """Return the address of the model's friction block, 0 where it has none."""
    count = word_at(model + offset_of(F_NNUMERIC))
    if count == 0:
        return 0
    places = integers(model, F_NUMERIC_ADR, count)
    start = word_at(model + offset_of(F_NUMERIC_DATA))
    for i in range(count):
        where = start + 8 * int(places[i])
        if window_at(where, 1)[0] == at.MAGIC and window_at(where, at.HEADER)[at.H_VERSION] == at.VERSION:
            return int(where)
    return 0


@kernel
def open_block(address: int, nv: int, n: int, k: int) -> Block:
    """Return the model's block that begins at an address, of ``nv`` dofs, ``n`` touched and ``k`` rubbing.

    The caller passes the sizes, so that they can be constants of its compiled code.
    """
    head = window_at(address, at.HEADER)
    return Block(
        address,
        nv,
        int(head[at.H_PLACES]),
        int(head[at.H_BODIES]),
        n,
        k,
        int(head[at.H_TERMS]),
        int(head[at.H_STATES]),
        head[at.H_LOAD] > 0.0,
        int(head[at.H_ACTUATORS]),
        head[at.H_DRIVEN] > 0.0,
        head[at.H_FORESEEN] > 0.0,
        address + 8 * int(head[at.H_TERM_TABLE]),
        window_at(address + 8 * int(head[at.H_DOF_LIST]), n),
        window_at(address + 8 * int(head[at.H_LOCAL]), nv),
        window_at(address + 8 * int(head[at.H_POSITIONS]), k),
    )


@kernel
def has_room(model: int, block: Block) -> bool:
    """Return whether the user data is as long as the block needs; with a block from elsewhere it may not be."""
    base = int(window_at(block.address, at.HEADER)[at.H_BASE])
    room = at.U_SCALARS + at.TOUCHED_ARRAYS * block.touched + at.RUBBING_ARRAYS * block.rubbing + 2 * block.states
    return bool(base + room <= word_at(model + offset_of(F_NUSERDATA)))


@kernel
def open_kept(data: int, block: Block) -> Kept:
    """Return the simulation's block."""
    n, k = block.touched, block.rubbing
    base = int(window_at(block.address, at.HEADER)[at.H_BASE])
    user = numbers(
        data, F_USERDATA, base + at.U_SCALARS + at.TOUCHED_ARRAYS * n + at.RUBBING_ARRAYS * k + 2 * block.states
    )
    u = base + at.U_SCALARS
    r = u + at.TOUCHED_ARRAYS * n
    return Kept(
        window(user, base, at.U_SCALARS),
        window(user, u, n),
        window(user, u + n, n),
        window(user, u + 2 * n, n),
        window(user, u + 3 * n, n),
        window(user, r, k),
        window(user, r + k, k),
        window(user, r + 2 * k, k),
        window(user, r + 3 * k, k),
        window(user, r + 4 * k, k),
        window(user, r + 5 * k, k),
        window(user, r + at.RUBBING_ARRAYS * k, block.states),
        window(user, r + at.RUBBING_ARRAYS * k + block.states, block.states),
    )


@kernel
def open_desk(data: int, block: Block) -> Desk:
    """Allocate the work space on MuJoCo's stack, which the caller has marked."""
    n, k, nv = block.touched, block.rubbing, block.nv
    matrices = n * n + 2 * k * k
    work = stack_numbers(data, matrices + 3 * n + (6 + AMBIENT_SIZE) * k + nv + AMBIENT_SIZE)
    o = work + 8 * matrices
    r = o + 24 * n
    e = r + 8 * (6 + AMBIENT_SIZE) * k
    return Desk(
        matrix_at(work, n, n),
        matrix_at(work + 8 * n * n, k, k),
        matrix_at(work + 8 * (n * n + k * k), k, k),
        window_at(o, n),
        window_at(o + 8 * n, n),
        window_at(o + 16 * n, n),
        window_at(o + 16 * n + 8 * (n - k), k),
        window_at(r, k),
        window_at(r + 8 * k, k),
        window_at(r + 16 * k, k),
        window_at(r + 24 * k, k),
        window_at(r + 32 * k, k),
        window_at(r + 40 * k, k),
        matrix_at(r + 48 * k, k, AMBIENT_SIZE),
        window_at(e, nv),
        window_at(e + 8 * nv, AMBIENT_SIZE),
    )
