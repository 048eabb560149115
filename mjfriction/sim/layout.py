"""Offsets in MuJoCo's structs of the fields that the compiled callback reads: found at run time, never hard-coded.

Probe models with known contents are built.  The offsets that hold, in every probe, the addresses that the Python
bindings report (or numbers set through them) are those of the fields.  A MuJoCo whose structs do not match is refused.
"""

from __future__ import annotations

import ctypes
import enum
import functools
import os

import mujoco
import numpy as np
from numpy.typing import NDArray

from mjfriction.errors import SimulationError

CHUNK = 4096
FARTHEST = {"mjModel": 64 * 1024, "mjData": 1024 * 1024}  # bytes searched; mjData begins with long statistics

MODEL_ARRAYS = (
    "numeric_adr",
    "numeric_data",
    "M_rownnz",
    "M_rowadr",
    "M_colind",
    "dof_damping",
    "dof_armature",
    "actuator_biastype",
    "actuator_biasprm",
)
DATA_ARRAYS = (
    "qpos",
    "qvel",
    "userdata",
    "M",
    "qfrc_passive",
    "qfrc_bias",
    "qfrc_applied",
    "xfrc_applied",
    "qfrc_actuator",
    "xipos",
    "moment_rownnz",
    "moment_rowadr",
    "moment_colind",
    "actuator_moment",
)


class Field(enum.IntEnum):
    """Entries of the table of offsets; the last one is the callback to call first, not an offset."""

    NNUMERIC = 0
    TIMESTEP = 1
    INTEGRATOR = 2
    DISABLEFLAGS = 3
    TIME = 4
    NUMERIC_ADR = 5
    NUMERIC_DATA = 6
    M_ROWNNZ = 7
    M_ROWADR = 8
    M_COLIND = 9
    DOF_DAMPING = 10
    DOF_ARMATURE = 11
    ACTUATOR_BIASTYPE = 12
    ACTUATOR_BIASPRM = 13
    QPOS = 14
    QVEL = 15
    USERDATA = 16
    M = 17
    QFRC_PASSIVE = 18
    QFRC_BIAS = 19
    QFRC_APPLIED = 20
    XFRC_APPLIED = 21
    QFRC_ACTUATOR = 22
    XIPOS = 23
    MOMENT_ROWNNZ = 24
    MOMENT_ROWADR = 25
    MOMENT_COLIND = 26
    ACTUATOR_MOMENT = 27
    NUSERDATA = 28
    NEFC = 29
    PREVIOUS_CALLBACK = 30


PROBE = """
<mujoco>
  <option timestep="{timestep}" integrator="{integrator}"><flag {flag}="disable"/></option>
  <size nuserdata="{extra}"/>
  <worldbody>{bodies}</worldbody>
  <actuator>{motors}</actuator>
  <custom>{numerics}</custom>
</mujoco>
"""
PROBES = (
    (0, "Euler", "gravity"),
    (1, "implicit", "limit"),
    (3, "implicitfast", "contact"),
    (5, "discrete", "equality"),
)


def _probe(extra: int, integrator: str, flag: str) -> tuple[mujoco.MjModel, mujoco.MjData]:
    joints = range(3 + extra)
    child = '<body><joint/><geom size=".1"/></body>'
    limits = 'limited="true" range="-1 1"'
    bodies = "".join(f'<body><joint name="j{i}" damping="1" {limits}/><geom size=".1"/>{child}</body>' for i in joints)
    motors = "".join(f'<position joint="j{i}" kp="1" kv="1"/>' for i in joints)
    numerics = "".join(f'<numeric name="n{i}" data="1 2"/>' for i in range(11 + 2 * extra))
    text = PROBE.format(
        timestep=0.00123 + 1e-5 * extra,
        integrator=integrator,
        flag=flag,
        extra=7 + extra,
        bodies=bodies,
        motors=motors,
        numerics=numerics,
    )
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    # Fewer constraints the second time, and in two islands: else their number would also be the largest so far, or that
    # of the first island.
    for beyond in (3, 2):
        data.qpos[: 2 * beyond : 2] = 2.0
        mujoco.mj_forward(model, data)
        data.qpos[:] = 0.0
    data.time = 0.0456 + extra
    return model, data


def _memory(address: int, limit: int) -> bytes:
    # Writing the memory into a pipe turns an unmapped address into a failed write instead of a crash.
    libc = ctypes.CDLL(None, use_errno=True)
    libc.write.argtypes = (ctypes.c_int, ctypes.c_void_p, ctypes.c_size_t)
    libc.write.restype = ctypes.c_ssize_t
    reader, writer = os.pipe()
    out = []
    try:
        for at in range(address, address + limit, CHUNK):
            if libc.write(writer, at, CHUNK) != CHUNK:
                break
            out.append(os.read(reader, CHUNK))
    finally:
        os.close(reader)
        os.close(writer)
    return b"".join(out)


def _place(structs: list[bytes], values: list[bytes], name: str) -> int:
    """Return the first aligned offset at which every struct holds its value."""
    kind = np.dtype(f"u{len(values[0])}")
    held = [
        np.frombuffer(struct, kind) == np.frombuffer(value, kind) for struct, value in zip(structs, values, strict=True)
    ]
    shortest = min(own.size for own in held)
    places = np.flatnonzero(np.all([own[:shortest] for own in held], axis=0))
    if not places.size:
        raise SimulationError(
            f"MuJoCo {mujoco.__version__}: field {name} is not where the bindings say; this layout is not understood. "
            "Use a MuJoCo 4 release that mjfriction was tested with"
        )
    return int(places[0]) * kind.itemsize


@functools.cache
def field_offsets() -> NDArray[np.int64]:
    """Return the byte offset of every :class:`Field`, shape (fields,); raises :class:`SimulationError` if not found."""
    probes = [_probe(*probe) for probe in PROBES]
    models = [_memory(model._address, FARTHEST["mjModel"]) for model, _ in probes]
    datas = [_memory(data._address, FARTHEST["mjData"]) for _, data in probes]

    def number(value: float | int, kind: type[np.generic]) -> bytes:
        return np.array(value, dtype=kind).tobytes()

    def pointer(owner: object, name: str) -> bytes:
        return number(getattr(owner, name).ctypes.data, np.uint64)

    offsets = np.zeros(len(Field), dtype=np.int64)
    scalars = (
        (Field.NNUMERIC, models, [number(m.nnumeric, np.int64) for m, _ in probes]),
        (Field.NUSERDATA, models, [number(m.nuserdata, np.int64) for m, _ in probes]),
        (Field.TIMESTEP, models, [number(m.opt.timestep, np.float64) for m, _ in probes]),
        (Field.INTEGRATOR, models, [number(m.opt.integrator, np.int32) for m, _ in probes]),
        (Field.DISABLEFLAGS, models, [number(m.opt.disableflags, np.int32) for m, _ in probes]),
        (Field.TIME, datas, [number(d.time, np.float64) for _, d in probes]),
        (Field.NEFC, datas, [number(d.nefc, np.int32) for _, d in probes]),
    )
    for field, structs, values in scalars:
        offsets[field] = _place(structs, values, field.name.lower())
    for name in MODEL_ARRAYS:
        offsets[Field[name.upper()]] = _place(models, [pointer(m, name) for m, _ in probes], name)
    for name in DATA_ARRAYS:
        offsets[Field[name.upper()]] = _place(datas, [pointer(d, name) for _, d in probes], name)
    return offsets
