"""The interface of every friction law.

A law is data: declared parameters, a number of states, and two compiled kernels.  Kernels store nothing; the state is
passed in and out.

``steady(v, ambient, p) -> torque``
    Steady-state friction at constant velocity ``v``.  Torque has the sign of ``v`` where the law dissipates: it is the
    torque that the drive must supply, so it has a plus sign in the robot's torque balance.

``advance(v, ambient, z, h, p, z_next) -> (torque, slope)``
    One step of length ``h`` in which the velocity is ``v``: the state goes from ``z`` to ``z_next``, and ``torque`` is
    the friction at the end of the step.  ``slope`` ≥ 0 estimates ∂torque/∂v, so that a joint can be stepped implicitly.

``v`` is in rad/s or m/s; ``ambient`` (7,) holds what else a law may read (:mod:`mjfriction.laws.ambient`: the load of
the transmission, position, temperature, pressures); ``p`` holds the scalar parameters, followed by the parameters of
the law's elements, one array after another; ``z`` is the state.  All but ``v`` are one-dimensional float64 arrays.
"""

from __future__ import annotations

import functools
import math
import numbers
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeVar, cast

import numba
import numpy as np
from numba import types
from numpy.typing import NDArray

from mjfriction.errors import LawError, suggestion
from mjfriction.laws.kept_code import let_go_of_stale_code
from mjfriction.laws.rules import Rule, Values
from mjfriction.parameter import Parameter

Floats = NDArray[np.float64]
Steady = Callable[[float, Floats, Floats], float]
Advance = Callable[[float, Floats, Floats, float, Floats, Floats], tuple[float, float]]
Kernel = TypeVar("Kernel", bound=Callable[..., Any])

let_go_of_stale_code(Path(__file__).parents[1])  # before the first kernel loads its cached code


def kernel(function: Kernel) -> Kernel:
    """Compile a small kernel on first use, inlined where it is called; the machine code is cached on disk."""
    return cast(Kernel, numba.njit(cache=True, error_model="numpy", forceinline=True)(function))


def routine(function: Kernel) -> Kernel:
    """Compile a function that calls kernels and is itself called rather than inlined."""
    return cast(Kernel, numba.njit(cache=True, error_model="numpy")(function))


@dataclass(frozen=True, slots=True)
class Law:
    """A friction law: its name, its parameters and its kernels.

    ``captures`` and ``misses`` say in one line what it can and cannot represent.  ``elements`` are the parameters of
    each element, for a law built of elements.  The state has ``states`` values plus ``states_per_element`` for every
    element.  ``odd`` means torque(−v) = −torque(v); ``exact_state`` means that two half steps equal one whole step up
    to rounding; ``reads`` lists the columns of ``ambient`` that affect its torque.
    """

    name: str
    summary: str
    captures: str
    misses: str
    formula: str
    source: str
    parameters: tuple[Parameter, ...]
    steady: Steady
    advance: Advance
    elements: tuple[Parameter, ...] = ()
    states: int = 0
    states_per_element: int = 0
    odd: bool = True
    exact_state: bool = True
    reads: tuple[int, ...] = ()
    rules: tuple[Rule, ...] = field(default=())

    @property
    def has_state(self) -> bool:
        """Whether the law depends on the history of the motion."""
        return bool(self.states or self.states_per_element)

    def parameter(self, name: str) -> Parameter:
        """Return the declaration of a parameter; :class:`LawError` suggests the nearest one if there is none."""
        declared = {parameter.name: parameter for parameter in (*self.parameters, *self.elements)}
        if name in declared:
            return declared[name]
        raise LawError(
            f"law '{self.name}' has no parameter '{name}'{suggestion(name, declared)} It takes {', '.join(declared)}"
        )

    def index(self, name: str) -> int | None:
        """Return the index of a scalar parameter in the packed values, None if the law has none of that name."""
        names = [parameter.name for parameter in self.parameters]
        return names.index(name) if name in names else None

    def element_count(self, packed: Floats) -> int:
        """Return the number of elements that packed values describe."""
        return (packed.size - len(self.parameters)) // len(self.elements) if self.elements else 0

    def state_count(self, packed: Floats) -> int:
        """Return the number of values in the state."""
        return self.states + self.states_per_element * self.element_count(packed)

    def pack(self, values: Values, *, where: str = "") -> Floats:
        """Check named values against the declarations and return them in the order the kernels read.

        Raises :class:`LawError` naming law, parameter, unit and value for a name that is unknown or missing, a value
        out of bounds, arrays of different lengths, or values that break a rule of the law.  ``where`` (e.g. a joint)
        is put in front of the message.
        """
        at = f"{where}: " if where else ""
        for name in values:
            try:
                self.parameter(name)
            except LawError as error:
                raise LawError(f"{at}{error}") from None
        full = {p.name: p.default for p in self.parameters if p.default is not None} | dict(values)
        packed = [self._checked(parameter, full, at) for parameter in self.parameters]
        arrays = [self._checked_elements(parameter, full, at) for parameter in self.elements]
        for parameter, own in zip(self.elements[1:], arrays[1:], strict=True):
            if len(own) != len(arrays[0]):
                raise LawError(
                    f"{at}law '{self.name}': '{self.elements[0].name}' has {len(arrays[0])} values and "
                    f"'{parameter.name}' {len(own)}; give one of each for every element"
                )
        for rule in self.rules:
            broken = rule.broken(full)
            if broken is not None:
                raise LawError(f"{at}law '{self.name}': {broken}")
        return np.array([*packed, *(value for own in arrays for value in own)], dtype=np.float64)

    def _checked(self, parameter: Parameter, values: Values, at: str) -> float:
        if parameter.name not in values:
            raise LawError(
                f"{at}law '{self.name}' needs '{parameter.name}' ({parameter.meaning}, "
                f"{parameter.unit_for(sliding=False)}); add it to the parameters"
            )
        value = values[parameter.name]
        if not isinstance(value, numbers.Real) or isinstance(value, bool):
            raise LawError(f"{at}law '{self.name}', parameter '{parameter.name}' is one number, not {value!r}")
        return self._allowed(parameter, float(value), parameter.name, at)

    def _checked_elements(self, parameter: Parameter, values: Values, at: str) -> list[float]:
        if parameter.name not in values:
            raise LawError(
                f"{at}law '{self.name}' needs '{parameter.name}' ({parameter.meaning}, "
                f"{parameter.unit_for(sliding=False)}), a list with one value for every element"
            )
        value = values[parameter.name]
        if isinstance(value, numbers.Real) or not hasattr(value, "__len__") or len(value) == 0:
            raise LawError(
                f"{at}law '{self.name}', parameter '{parameter.name}' is a list with one value for every element"
            )
        return [
            self._allowed(parameter, float(x), f"{parameter.name}[{i}]", at)
            for i, x in enumerate(cast(Sequence[float], value))
        ]

    def _allowed(self, parameter: Parameter, value: float, name: str, at: str) -> float:
        if not parameter.allows(value):
            finite = "" if math.isfinite(value) else "finite, "
            raise LawError(
                f"{at}law '{self.name}', parameter '{name}' = {value:g} "
                f"{parameter.unit_for(sliding=False)}: allowed is {finite}{parameter.allowed}"
            )
        return value

    def unpack(self, packed: Floats) -> dict[str, float | tuple[float, ...]]:
        """Return packed values by name."""
        scalars = {p.name: float(value) for p, value in zip(self.parameters, packed, strict=False)}
        arrays = packed[len(self.parameters) :].reshape(len(self.elements), -1) if self.elements else ()
        return scalars | {p.name: tuple(own.tolist()) for p, own in zip(self.elements, arrays, strict=True)}

    def along(self, velocity: Floats, ambient: Floats, packed: Floats) -> Floats:
        """Return the steady friction at every sample.

        ``velocity`` (n,), ``ambient`` (n, 7), ``packed`` from :meth:`pack`; the result has shape (n,).
        """
        out = np.empty(velocity.shape[0])
        _steady_loop()(self.steady, _rowwise(velocity), _rowwise(ambient), packed, out)
        return out

    def follow(
        self, velocity: Floats, ambient: Floats, h: float, packed: Floats, state: Floats | None = None
    ) -> tuple[Floats, Floats]:
        """Return the friction at the end of every step of a motion, (n,), and the state there, (n, states).

        ``velocity`` (n,) is held during each step of ``h`` seconds.  ``state`` (states,) is the initial state; by
        default the law starts at rest without deflection.
        """
        count = self.state_count(packed)
        start = np.zeros(count) if state is None else np.array(state, dtype=np.float64)
        if start.shape != (count,):
            raise LawError(f"law '{self.name}' has {count} states here, not {start.shape}; give that many")
        torque, states = np.empty(velocity.shape[0]), np.empty((velocity.shape[0], count))
        _advance_loop()(self.advance, _rowwise(velocity), _rowwise(ambient), h, packed, start, torque, states)
        return torque, states


def _rowwise(values: Floats) -> Floats:
    return np.ascontiguousarray(values, dtype=np.float64)


def _steady_along(steady: Steady, velocity: Floats, ambient: Floats, packed: Floats, out: Floats) -> None:
    for i in range(velocity.shape[0]):
        out[i] = steady(velocity[i], ambient[i], packed)


def _advance_along(
    advance: Advance, v: Floats, ambient: Floats, h: float, p: Floats, start: Floats, torque: Floats, states: Floats
) -> None:
    z = start
    for i in range(v.shape[0]):
        torque[i], _ = advance(v[i], ambient[i], z, h, p, states[i])
        z = states[i]


_VECTOR = types.float64[::1]
_TABLE = types.float64[:, ::1]


@functools.cache
def _steady_loop() -> Callable[..., None]:
    # One loop serves all laws: the kernel is passed as a function pointer, so that the loop is compiled only once and
    # can be cached on disk.
    steady = types.FunctionType(types.float64(types.float64, _VECTOR, _VECTOR))
    signature = types.void(steady, _VECTOR, _TABLE, _VECTOR, _VECTOR)
    return cast(Callable[..., None], numba.njit(signature, cache=True)(_steady_along))


@functools.cache
def _advance_loop() -> Callable[..., None]:
    scalar = types.float64
    pair = cast(Any, types).UniTuple(scalar, 2)
    advance = types.FunctionType(pair(scalar, _VECTOR, _VECTOR, scalar, _VECTOR, _VECTOR))
    signature = types.void(advance, _VECTOR, _TABLE, scalar, _VECTOR, _VECTOR, _VECTOR, _TABLE)
    return cast(Callable[..., None], numba.njit(signature, cache=True)(_advance_along))


def positive(
    name: str, unit: str, meaning: str, typical: tuple[float, float], default: float | None = None
) -> Parameter:
    """Declare a parameter that may not be negative."""
    return Parameter(name, unit, meaning, lower=0.0, upper=math.inf, typical=typical, default=default)


def above_zero(
    name: str, unit: str, meaning: str, typical: tuple[float, float], default: float | None = None
) -> Parameter:
    """Declare a parameter that must be larger than zero."""
    return Parameter(name, unit, meaning, lower=1e-12, upper=math.inf, typical=typical, default=default)
