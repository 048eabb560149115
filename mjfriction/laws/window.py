"""Array views that own no memory: in compiled code, a slice costs as much as a step of a law, and a window nothing."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, cast

from llvmlite import ir
from numba import types
from numba.extending import intrinsic
from numba.np import arrayobj

_arrays: Any = arrayobj
VECTOR, INTEGERS, MATRIX = types.float64[::1], types.int32[::1], types.float64[:, ::1]


def built(function: Callable[..., Any]) -> Callable[..., Any]:
    """Declare a function that generates machine instructions; its first parameter is supplied by the compiler."""
    return cast(Callable[..., Any], intrinsic(function))


def _view(context: Any, builder: Any, kind: Any, pointer: Any, count: Any) -> Any:
    view = _arrays.make_array(kind)(context, builder)
    size = context.get_constant(types.intp, kind.dtype.bitwidth // 8)
    _arrays.populate_array(view, data=pointer, shape=[count], strides=[size], itemsize=size, meminfo=None)
    return view._getvalue()


@built
def window(typing_context: Any, array: Any, start: Any, count: Any) -> Any:
    """Return ``array[start : start + count]`` of a contiguous float64 array; the array must outlive the view."""
    del typing_context, start, count

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        whole = _arrays.make_array(signature.args[0])(context, builder, arguments[0])
        flat = builder.bitcast(whole.data, ir.DoubleType().as_pointer())
        return _view(context, builder, VECTOR, builder.gep(flat, [arguments[1]]), arguments[2])

    return VECTOR(array, types.intp, types.intp), generate


@built
def address(typing_context: Any, array: Any, start: Any) -> Any:
    """Return the memory address of ``array[start]`` of a contiguous float64 array."""
    del typing_context, start

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        whole = _arrays.make_array(signature.args[0])(context, builder, arguments[0])
        flat = builder.bitcast(whole.data, ir.DoubleType().as_pointer())
        return builder.ptrtoint(builder.gep(flat, [arguments[1]]), ir.IntType(64))

    return types.int64(array, types.intp), generate


@built
def window_at(typing_context: Any, address: Any, count: Any) -> Any:
    """Return a view of the ``count`` float64 numbers that begin at an address."""
    del typing_context, address, count

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        del signature
        pointer = builder.inttoptr(arguments[0], ir.DoubleType().as_pointer())
        return _view(context, builder, VECTOR, pointer, arguments[1])

    return VECTOR(types.intp, types.intp), generate


@built
def integers_at(typing_context: Any, address: Any, count: Any) -> Any:
    """Return a view of the ``count`` 32-bit integers that begin at an address."""
    del typing_context, address, count

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        del signature
        pointer = builder.inttoptr(arguments[0], ir.IntType(32).as_pointer())
        return _view(context, builder, INTEGERS, pointer, arguments[1])

    return INTEGERS(types.intp, types.intp), generate


@built
def matrix_at(typing_context: Any, address: Any, rows: Any, columns: Any) -> Any:
    """Return a view of the ``rows`` by ``columns`` float64 numbers that begin at an address, row after row."""
    del typing_context, address, rows, columns

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        del signature
        pointer = builder.inttoptr(arguments[0], ir.DoubleType().as_pointer())
        size = context.get_constant(types.intp, 8)
        shape, strides = list(arguments[1:]), [builder.mul(arguments[2], size), size]
        view = _arrays.make_array(MATRIX)(context, builder)
        _arrays.populate_array(view, data=pointer, shape=shape, strides=strides, itemsize=size, meminfo=None)
        return view._getvalue()

    return MATRIX(types.intp, types.intp, types.intp), generate
