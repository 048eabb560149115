"""Reaching MuJoCo's memory and functions from compiled code."""

from __future__ import annotations

import functools
import importlib.util
from pathlib import Path
from typing import Any, cast

import llvmlite.binding as llvm
from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from mjfriction.errors import SimulationError
from mjfriction.sim.layout import field_offsets

TABLE = "mjfriction_field_offsets"
WORD = ir.IntType(64)

# MuJoCo's own functions; addresses travel as integers of the same size.
_STRUCTS = types.void(types.intp, types.intp)
fwd_actuation = types.ExternalFunction("mj_fwdActuation", _STRUCTS)
mark_stack = types.ExternalFunction("mj_markStack", types.void(types.intp))
free_stack = types.ExternalFunction("mj_freeStack", types.void(types.intp))
stack_numbers = types.ExternalFunction("mj_stackAllocNum", types.intp(types.intp, types.intp))
warning = types.ExternalFunction("mj_warning", types.void(types.intp, types.int32, types.int32))
apply_force = types.ExternalFunction(
    "mj_applyFT",
    types.void(types.intp, types.intp, types.intp, types.intp, types.intp, types.int32, types.intp),
)


@intrinsic
def offset_of(typing_context: Any, field: Any) -> Any:
    """Return an entry of the table of field offsets, which lives outside the compiled code."""
    del typing_context, field

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        del context, signature
        table = builder.module.globals.get(TABLE)
        if table is None:
            table = ir.GlobalVariable(builder.module, WORD, TABLE)
            table.linkage = "external"
        return builder.load(builder.gep(table, [arguments[0]]))

    return types.int64(types.int64), generate


@intrinsic
def pointed(typing_context: Any, address: Any) -> Any:
    """Turn an address into a pointer that ``carray`` takes."""
    del typing_context, address

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        del context, signature
        return builder.inttoptr(arguments[0], ir.IntType(8).as_pointer())

    return types.voidptr(types.intp), generate


@intrinsic
def word_at(typing_context: Any, address: Any) -> Any:
    """Return the 64-bit word at an address: a pointer or a size."""
    del typing_context, address

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        del context, signature
        return builder.load(builder.inttoptr(arguments[0], WORD.as_pointer()))

    return types.int64(types.intp), generate


@intrinsic
def call_back(typing_context: Any, address: Any, model: Any, data: Any) -> Any:
    """Call the function at ``address`` with two addresses, as MuJoCo calls its callbacks."""
    del typing_context, address, model, data

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        del signature
        kind = ir.FunctionType(ir.VoidType(), [WORD, WORD])
        builder.call(builder.inttoptr(arguments[0], kind.as_pointer()), arguments[1:])
        return context.get_dummy_value()

    return types.void(types.intp, types.intp, types.intp), generate


@functools.cache
def offsets_table() -> Any:
    """Find the field offsets, link MuJoCo's library and the table into compiled code, and return the table (int64)."""
    spec = importlib.util.find_spec("mujoco")
    folder = Path(cast(str, cast(Any, spec).origin)).parent
    found = [p for pattern in ("libmujoco.so*", "libmujoco*.dylib", "mujoco.dll") for p in folder.glob(pattern)]
    if not found:
        raise SimulationError(f"{folder}: MuJoCo's shared library is not there; install the mujoco wheel again")
    llvm.load_library_permanently(str(found[0]))
    table = field_offsets().copy()
    llvm.add_symbol(TABLE, table.ctypes.data)
    return table
