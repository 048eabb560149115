"""The one callback of the process: compiled, without Python, and shared by all models."""

from __future__ import annotations

import ctypes
import functools
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import mujoco
import numba
from numba import types

from mjfriction.errors import SimulationError
from mjfriction.sim.layout import Field
from mjfriction.sim.native import call_back, offset_of, offsets_table
from mjfriction.sim.step import friction_step

PREVIOUS = int(Field.PREVIOUS_CALLBACK)


def _callback(model: int, data: int) -> None:
    previous = offset_of(PREVIOUS)
    if previous != 0:
        call_back(previous, model, data)
    friction_step(model, data)


@functools.cache
def compiled_callback() -> Any:
    """Return the callback as a ctypes function; compiled once and cached on disk."""
    offsets_table()
    return numba.cfunc(types.void(types.intp, types.intp), cache=True, error_model="numpy")(_callback).ctypes


@dataclass
class _Use:
    # Who needs the callback: open ``with`` blocks, and whoever installed it for good; and what was there before.
    blocks: int = 0
    for_good: bool = False
    replaced: Any = None


_use = _Use()  # the one global of the package: MuJoCo has one control callback
_lock = threading.RLock()


@contextmanager
def friction_active() -> Iterator[None]:
    """Install the friction callback for the duration of a ``with`` block.

    Blocks may be nested or overlap, also in several threads: the callback is removed with the last of them.  A native
    callback that was installed before (a ctypes function) is called first in every step and is restored afterwards.  A
    Python callback is refused with :class:`SimulationError`: it could not run in MuJoCo's thread pools.
    """
    with _lock:
        _put_in()
        _use.blocks += 1
    try:
        yield
    finally:
        with _lock:
            _use.blocks -= 1
            if _use.blocks == 0 and not _use.for_good:
                _take_out()


def install() -> bool:
    """Install the callback permanently, for a viewer or a notebook; return False where it is installed already.

    :func:`remove` removes it again.
    """
    with _lock:
        new = _put_in()
        # Put back within a block in which it was removed, it ends with the block.
        _use.for_good |= not (new and _use.blocks)
        return new


def remove() -> None:
    """Remove the callback and restore the one that was there before :func:`install`."""
    with _lock:
        _take_out()
        _use.for_good = False


def _put_in() -> bool:
    own = compiled_callback()
    table = offsets_table()
    there = mujoco.get_mjcb_control()
    if there is own:
        return False
    if there is not None and not isinstance(there, ctypes._CFuncPtr):  # type: ignore[attr-defined]
        raise SimulationError(
            f"a Python control callback is installed ({there!r}); friction runs inside MuJoCo's threads and cannot "
            "call it. Remove it with mujoco.set_mjcb_control(None) and set the controls in your loop, or compile it"
        )
    table[PREVIOUS] = 0 if there is None else ctypes.cast(there, ctypes.c_void_p).value or 0
    _use.replaced = there
    mujoco.set_mjcb_control(own)
    return True


def _take_out() -> None:
    there = mujoco.get_mjcb_control()
    if there is None:
        raise SimulationError("no control callback is installed; there is nothing to remove")
    if there is not compiled_callback():
        raise SimulationError(
            "another control callback was installed over the friction callback; remove that one first"
        )
    mujoco.set_mjcb_control(_use.replaced)
    offsets_table()[PREVIOUS] = 0
    _use.replaced = None
