"""The interface every friction law stands behind.

A law is data: declared parameters, a number of states, and two compiled kernels.  Kernels keep nothing; state goes in
and comes out.

``steady(v, load, p) -> torque``
    Friction at velocity ``v`` held for ever.  Torque has the sign of ``v`` where the law dissipates: it is the torque
    the drive must supply, so it stands with a plus sign in the balance of the robot.

``advance(v, load, z, h, p, z_next) -> (torque, slope)``
    One step of length ``h`` in which the velocity is ``v``: the state goes from ``z`` to ``z_next``.  ``slope`` ≥ 0
    estimates ∂torque/∂v, so that a joint can be stepped implicitly.

``v`` in rad/s or m/s, ``load`` (the torque the transmission carries) in N·m or N, ``p`` and ``z`` one-dimensional
float64 arrays.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, TypeVar, cast

import numba
import numpy as np
from numba import types
from numpy.typing import NDArray

from mjfriction.errors import LawError, suggestion
from mjfriction.parameter import Parameter

Floats = NDArray[np.float64]
Steady = Callable[[float, float, Floats], float]
Advance = Callable[[float, float, Floats, float, Floats, Floats], tuple[float, float]]
Kernel = TypeVar("Kernel", bound=Callable[..., Any])


def kernel(function: Kernel) -> Kernel:
    """Compile a law's kernel on first use; the machine code is kept between processes."""
    return cast(Kernel, numba.njit(cache=True, error_model="numpy")(function))


@dataclass(frozen=True, slots=True)
class Ordering:
    """A requirement ``larger >= smaller`` between two parameters of a law."""

    larger: str
    smaller: str


@dataclass(frozen=True, slots=True)
class Law:
    """A friction law: what it is called, what it needs, and its kernels.

    ``odd`` says torque(−v) = −torque(v); ``exact_state`` says two half steps equal one whole step to rounding.
    """

    name: str
    summary: str
    formula: str
    source: str
    parameters: tuple[Parameter, ...]
    steady: Steady
    advance: Advance
    state_count: int = 0
    odd: bool = True
    exact_state: bool = True
    orderings: tuple[Ordering, ...] = field(default=())

    def parameter(self, name: str) -> Parameter:
        """Return the declaration of a parameter; :class:`LawError` names the nearest one when there is none."""
        for parameter in self.parameters:
            if parameter.name == name:
                return parameter
        names = [parameter.name for parameter in self.parameters]
        raise LawError(
            f"law '{self.name}' has no parameter '{name}'{suggestion(name, names)} It takes {', '.join(names)}"
        )

    def pack(self, values: Mapping[str, float], *, where: str = "") -> Floats:
        """Check named values against the declarations and return them in the order the kernels read.

        Raises :class:`LawError` naming law, parameter, unit and value for a name that is unknown or missing, a value
        out of bounds, or two values in the wrong order.  ``where`` (a joint, say) is put in front of the message.
        """
        at = f"{where}: " if where else ""
        for name in values:
            try:
                self.parameter(name)
            except LawError as error:
                raise LawError(f"{at}{error}") from None
        packed = np.empty(len(self.parameters))
        for i, parameter in enumerate(self.parameters):
            if parameter.name not in values:
                raise LawError(
                    f"{at}law '{self.name}' needs '{parameter.name}' ({parameter.meaning}, "
                    f"{parameter.unit_for(sliding=False)}); add it to the parameters"
                )
            value = float(values[parameter.name])
            if not parameter.allows(value):
                raise LawError(
                    f"{at}law '{self.name}', parameter '{parameter.name}' = {value:g} "
                    f"{parameter.unit_for(sliding=False)}: allowed is {parameter.allowed}"
                )
            packed[i] = value
        for rule in self.orderings:
            if values[rule.larger] < values[rule.smaller]:
                raise LawError(
                    f"{at}law '{self.name}': '{rule.larger}' = {values[rule.larger]:g} is smaller than "
                    f"'{rule.smaller}' = {values[rule.smaller]:g}; it must be at least as large"
                )
        return packed

    def along(self, velocity: Floats, load: Floats, packed: Floats) -> Floats:
        """Return the steady friction at every sample.

        ``velocity`` and ``load`` have shape (n,), ``packed`` comes from :meth:`pack`; the result has shape (n,).
        """
        out = np.empty(velocity.shape[0])
        _steady_loop()(self.steady, np.ascontiguousarray(velocity), np.ascontiguousarray(load), packed, out)
        return out


def _steady_along(steady: Steady, velocity: Floats, load: Floats, packed: Floats, out: Floats) -> None:
    for i in range(velocity.shape[0]):
        out[i] = steady(velocity[i], load[i], packed)


@functools.cache
def _steady_loop() -> Callable[..., None]:
    # One loop for every law: the kernel comes in as a function pointer, so that the loop is compiled once for all and
    # can be kept on disk.
    vector = types.float64[::1]
    steady = types.FunctionType(types.float64(types.float64, types.float64, vector))
    signature = types.void(steady, vector, vector, vector, vector)
    return cast(Callable[..., None], numba.njit(signature, cache=True)(_steady_along))


def positive(name: str, unit: str, meaning: str, typical: tuple[float, float]) -> Parameter:
    """Declare a parameter that may not be negative."""
    return Parameter(name, unit, meaning, lower=0.0, upper=math.inf, typical=typical)
