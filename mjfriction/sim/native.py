"""Reaching MuJoCo's memory and functions from compiled code."""

from __future__ import annotations

import functools
import importlib.util
from pathlib import Path
from typing import Any, cast

import llvmlite.binding as llvm
from llvmlite import ir
from numba import types

from mjfriction.errors import SimulationError
from mjfriction.laws.window import built
from mjfriction.sim.layout import field_offsets
from mjfriction.sim.rub import SYMBOL, compiled_rub

TABLE = "mjfriction_field_offsets"
WORD = ir.IntType(64)

# MuJoCo's own functions; addresses travel as integers of the same size.
_external = cast(Any, types).ExternalFunction
_STRUCTS = types.void(types.intp, types.intp)
fwd_actuation = _external("mj_fwdActuation", _STRUCTS)
mark_stack = _external("mj_markStack", types.void(types.intp))
free_stack = _external("mj_freeStack", types.void(types.intp))
stack_numbers = _external("mj_stackAllocNum", types.intp(types.intp, types.intp))
warning = _external("mj_warning", types.void(types.intp, types.int32, types.int32))
apply_force: Any = _external(
    "mj_applyFT",
    types.void(types.intp, types.intp, types.intp, types.intp, types.intp, types.int32, types.intp),
)


@built
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


@built
def word_at(typing_context: Any, address: Any) -> Any:
    """Return the 64-bit word at an address: a pointer or a size."""
    del typing_context, address

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        del context, signature
        return builder.load(builder.inttoptr(arguments[0], WORD.as_pointer()))

    return types.int64(types.intp), generate


@built
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
    """Find the field offsets, link MuJoCo, the table and the laws into compiled code; return the table (int64)."""
    spec = importlib.util.find_spec("mujoco")
    folder = Path(cast(str, cast(Any, spec).origin)).parent
    found = [p for pattern in ("libmujoco.so*", "libmujoco*.dylib", "mujoco.dll") for p in folder.glob(pattern)]
    if not found:
        raise SimulationError(f"{folder}: MuJoCo's shared library is not there; install the mujoco wheel again")
    llvm.load_library_permanently(str(found[0]))
    table = field_offsets().copy()
    llvm.add_symbol(TABLE, table.ctypes.data)
    llvm.add_symbol(SYMBOL, compiled_rub().address)
    return table
