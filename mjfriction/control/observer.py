"""The interface of every friction observer: gains, a compiled kernel, and a state that is passed in and out.

``advance(x, v, u, h, p, z, z_next) -> (friction, velocity)``
    One step of ``h`` seconds: ``x`` is the position measured at its beginning, ``v`` the velocity (used only by
    observers that need one), ``u`` the force, held over the step, that moves the mass apart from friction.  The state
    goes from ``z`` to ``z_next``.  The estimates returned refer to the beginning or the end of the step, depending on
    the observer.  Friction has the sign of the velocity where it dissipates: mass·dv/dt = u − friction.

SI units, joint side: N·m, rad, kg·m² on a turning joint, N, m, kg on a sliding one.
"""

from __future__ import annotations

import functools
import math
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, fields
from typing import Any, ClassVar, cast

import numba
import numpy as np
from numba import types

from mjfriction.errors import ControlError
from mjfriction.laws.law import Floats

Advance = Callable[[float, float, float, float, Floats, Floats, Floats], tuple[float, float]]


@dataclass(frozen=True)
class Observer(ABC):
    """An observer with its gains; concrete observers are final and declare the gains they need.

    ``mass`` is the mass or inertia that the force moves: kg, or kg·m².
    """

    mass: float

    advance: ClassVar[Advance]
    needs_velocity: ClassVar[bool] = False

    def __post_init__(self) -> None:
        for gain in fields(self):
            value = getattr(self, gain.name)
            if isinstance(value, float) and not math.isfinite(value):
                raise ControlError(f"{self.title}: {gain.name} = {value:g}; a finite number is needed")
        self.require(self.mass > 0.0, "mass", "above 0")

    @property
    def title(self) -> str:
        """The observer's name in messages."""
        return f"observer '{type(self).__name__}'"

    def require(self, holds: bool, gain: str, allowed: str) -> None:
        """Raise :class:`ControlError` naming a gain, its value and what is allowed, unless the condition ``holds``."""
        if not holds:
            raise ControlError(
                f"{self.title} does not converge with {gain} = {getattr(self, gain):g}; it must be {allowed}"
            )

    @property
    @abstractmethod
    def packed(self) -> Floats:
        """The gains as a vector for the kernel."""

    @abstractmethod
    def start(self, position: float, velocity: float = 0.0) -> Floats:
        """Return the initial state: the joint's position and velocity are known, its friction is not."""

    def check_step(self, step: float) -> None:
        """Raise :class:`ControlError` if the estimate would diverge with steps of this length (s)."""
        if not step > 0.0:
            raise ControlError(f"{self.title}: steps of {step:g} s; allowed is above 0")

    def require_settling(self, errors: Floats, step: float) -> None:
        """Raise :class:`ControlError` unless ``errors``, the errors' matrix from step to step, makes them decay."""
        largest = float(np.max(np.abs(np.linalg.eigvals(errors))))
        if largest >= 1.0:
            raise ControlError(
                f"{self.title}: at steps of {step:g} s its errors do not die away but change by {largest:.6g} a "
                "step; take other gains, lower its bandwidth, or step finer"
            )

    def step(
        self, state: Floats, position: float, velocity: float, force: float, step: float
    ) -> tuple[Floats, float, float]:
        """Return the next state and the estimated friction and velocity."""
        out = np.empty_like(state)
        friction, speed = type(self).advance(position, velocity, force, step, self.packed, state, out)
        return out, friction, speed


ObserverFor = Callable[[float, float], Observer]
"""(mass, step) → the observer of a joint that weighs so much, at steps of so many seconds."""


def estimate_along(
    observer: Observer, step: float, position: Floats, force: Floats, velocity: Floats | None = None
) -> tuple[Floats, Floats]:
    """Return friction and velocity, (n,) each, as an observer estimates them along samples ``step`` seconds apart.

    ``force`` (n,) is the force that moves the mass apart from friction.  Raises :class:`ControlError` if the observer
    needs a velocity and none is given, if it cannot work at this step, or if arrays have different lengths or values
    that are not finite.
    """
    observer.check_step(step)
    if velocity is None:
        if observer.needs_velocity:
            raise ControlError(f"{observer.title} needs a measured velocity; take one that estimates it")
        velocity = np.zeros(np.shape(position))
    columns = [np.ascontiguousarray(values, dtype=np.float64) for values in (position, velocity, force)]
    sizes = [column.shape for column in columns]
    if any(size != (columns[0].size,) for size in sizes) or columns[0].size == 0:
        raise ControlError(
            f"{observer.title}: position, velocity and force have shapes {sizes}; they must be alike, (n,)"
        )
    if not all(np.all(np.isfinite(column)) for column in columns):
        raise ControlError(f"{observer.title}: position, velocity and force must all be finite numbers")
    friction, speed = np.empty(columns[0].size), np.empty(columns[0].size)
    start = observer.start(float(columns[0][0]), float(columns[1][0]))
    _loop()(type(observer).advance, *columns, step, observer.packed, start, friction, speed)
    return friction, speed


def _along(
    advance: Advance, x: Floats, v: Floats, u: Floats, h: float, p: Floats, z: Floats, friction: Floats, speed: Floats
) -> None:
    z_next = np.empty_like(z)
    for i in range(x.shape[0]):
        friction[i], speed[i] = advance(x[i], v[i], u[i], h, p, z, z_next)
        z, z_next = z_next, z


_VECTOR = types.float64[::1]


@functools.cache
def _loop() -> Callable[..., None]:
    # One compiled loop serves every observer, as for the laws: the kernel is passed as a function pointer.
    number = types.float64
    pair = cast(Any, types).UniTuple(number, 2)
    advance = types.FunctionType(pair(number, number, number, number, _VECTOR, _VECTOR, _VECTOR))
    signature = types.void(advance, _VECTOR, _VECTOR, _VECTOR, number, _VECTOR, _VECTOR, _VECTOR, _VECTOR)
    return cast(Callable[..., None], numba.njit(signature, cache=True)(_along))
