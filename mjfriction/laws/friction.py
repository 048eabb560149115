"""A friction law with its values, as seen from a joint."""

from __future__ import annotations

import functools
import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from mjfriction.errors import LawError
from mjfriction.laws import wrapped
from mjfriction.laws.ambient import AMBIENT_SIZE, ROOM_TEMPERATURE, ambient
from mjfriction.laws.catalog import LAWS, find_law
from mjfriction.laws.law import Floats, Law
from mjfriction.laws.rules import Values

NUDGE = 1e-12  # rad or m, a travel at which no spring in a joint yields yet
CREEP = 1e-3  # rad/s or m/s on the law's side, a speed at which friction is its level with almost no damping
# The level at rest is the maximum over SPEEDS speeds from SLOWEST times the slow speed to that speed.
SLOWEST, SPEEDS = 1e-4, 9


@dataclass(frozen=True, slots=True)
class Wave:
    """A relative variation of the level along the stroke: a·cos(kq) + b·sin(kq), k in 1/rad or 1/m."""

    wavenumber: float
    cosine: float
    sine: float


@dataclass(frozen=True, slots=True)
class Level:
    """A factor on the level of a law: 1 + ``per_load``·|τ| + ``per_kelvin``·(T − T₀) + the waves.

    ``per_load`` is in 1/(N·m) or 1/N on the law's side, ``per_kelvin`` in 1/K, ``reference_temperature`` T₀ in °C.
    """

    per_load: float = 0.0
    per_kelvin: float = 0.0
    reference_temperature: float = ROOM_TEMPERATURE
    waves: tuple[Wave, ...] = ()


@dataclass(frozen=True)
class Friction:
    """One law with its values, seen from the joint.

    ``law`` refers to its own side of a gear: velocity there is ``gear_ratio`` times the joint's, and its torque is
    multiplied by the same ratio at the joint.  ``level`` scales all of the law except its linear damping.  ``negative``
    holds the values for backward motion where they differ; a law with them runs one copy for each direction.  The load
    that it reads is the torque that passes the transmission to the links; with ``load_includes_rotor`` it includes the
    torque of the drive's rotor.  Create one with :func:`friction`.
    """

    law: Law
    values: Floats
    negative: Floats | None = None
    gear_ratio: float = 1.0
    level: Level = field(default=Level())
    load_includes_rotor: bool = False

    @property
    def state_count(self) -> int:
        """The number of values in the state."""
        return self.law.state_count(self.values) * (1 if self.negative is None else 2)

    @functools.cached_property
    def packed(self) -> Floats:
        """The vector that the compiled kernels read; :mod:`mjfriction.laws.wrapped` describes its layout."""
        damping = self.law.index("viscous")
        header = np.zeros(wrapped.HEADER)
        header[wrapped.NUMBER] = list(LAWS).index(self.law.name)
        header[wrapped.RATIO] = self.gear_ratio
        header[wrapped.COUNT] = self.values.size
        header[wrapped.DAMPING] = -1.0 if damping is None else damping
        header[wrapped.TWO_WAY] = self.negative is not None
        header[wrapped.WHOLE] = self.load_includes_rotor
        header[wrapped.LEVELLED] = self.level != Level()
        header[wrapped.PER_LOAD] = self.level.per_load
        header[wrapped.PER_KELVIN] = self.level.per_kelvin
        header[wrapped.REFERENCE] = self.level.reference_temperature
        header[wrapped.WAVES] = len(self.level.waves)
        waves = [(wave.wavenumber, wave.cosine, wave.sine) for wave in self.level.waves]
        backward = np.empty(0) if self.negative is None else self.negative
        out = np.concatenate([header, np.array(waves).ravel(), self.values, backward])
        out.setflags(write=False)
        return out

    def steady(self, velocity: Floats, ambient: Floats) -> Floats:
        """Return the steady torque at the joint, (n,), for ``velocity`` (n,) and ``ambient`` (n, 7) of the joint."""
        out = np.empty(velocity.shape[0])
        near = np.empty(AMBIENT_SIZE)
        wrapped.steady_wrapped_along(_even(velocity), _even(ambient), self._writable, near, out)
        return out

    def at_rest(self, ambient: Floats, slow: float) -> Floats:
        """Return what the law can hold while the joint rests, (n,): its maximum over speeds up to ``slow``."""
        speeds = np.geomspace(SLOWEST * slow, slow, SPEEDS)
        ways = [np.full(ambient.shape[0], way * speed) for speed in speeds for way in (1.0, -1.0)]
        return np.asarray(np.max(np.abs([self.steady(way, ambient) for way in ways]), axis=0))

    def follow(self, velocity: Floats, ambient: Floats, h: float, state: Floats | None = None) -> tuple[Floats, Floats]:
        """Return the torque at the end of every step, (n,), and the state there, (n, states).

        ``velocity`` (n,) is the joint's velocity, held during each step of ``h`` seconds.  ``state`` is the initial
        state; by default the law starts at rest without deflection.
        """
        start = np.zeros(self.state_count) if state is None else np.array(state, dtype=np.float64)
        if start.shape != (self.state_count,):
            raise LawError(f"law '{self.law.name}' has {self.state_count} states here, not {start.shape}")
        torque, states = np.empty(velocity.shape[0]), np.empty((velocity.shape[0], self.state_count))
        near = np.empty(AMBIENT_SIZE)
        wrapped.advance_wrapped_along(_even(velocity), _even(ambient), h, self._writable, start, near, torque, states)
        return torque, states

    @functools.cached_property
    def travel(self) -> float:
        """The travel of the joint until the law's springs have yielded, rad or m.

        This is the level at rest divided by the stiffness there, at room temperature and without load.  It is infinite
        if the springs hold nothing, and 0 for a law without a state.
        """
        if self.state_count == 0:
            return 0.0
        # Move, then stop, so that the damping of the springs adds nothing.
        held = self.follow(np.array([CREEP, 0.0]), ambient(2), NUDGE / CREEP)[0][1]
        level = self.at_rest(ambient(1), CREEP / abs(self.gear_ratio))[0]
        return float(NUDGE * level / held) if held > 0.0 else math.inf

    @functools.cached_property
    def _writable(self) -> Floats:
        # Read-only arrays are a different type to compiled code, which would be compiled a second time for them.
        return self.packed.copy()


def _even(values: Floats) -> Floats:
    return np.ascontiguousarray(values, dtype=np.float64)


def friction(
    law: str,
    parameters: Values,
    *,
    negative: Values | None = None,
    gear_ratio: float = 1.0,
    level: Level | None = None,
    load_includes_rotor: bool = False,
    where: str = "",
) -> Friction:
    """Return a law by name with checked values.

    ``negative`` gives the values for backward motion; values that it omits are taken from ``parameters``.  With
    ``load_includes_rotor`` the load includes the torque of the drive's rotor.  ``where`` (e.g. a joint) is put in front
    of messages.  Raises :class:`LawError` for an unknown law, for values that the law does not allow, for a negative
    set with a law that is not odd, or for a gear ratio that is 0 or not finite.
    """
    at = f"{where}: " if where else ""
    try:
        found = find_law(law)
    except LawError as error:
        raise LawError(f"{at}{error}") from None
    values = found.pack(parameters, where=where)
    if not (math.isfinite(gear_ratio) and gear_ratio != 0.0):
        raise LawError(f"{at}law '{law}': gear_ratio = {gear_ratio:g}; allowed is any finite number but 0")
    backward = None
    if negative is not None:
        if not found.odd:
            raise LawError(f"{at}law '{law}' already has both directions; leave `negative` out")
        merged: Mapping[str, object] = {**parameters, **negative}
        backward = found.pack(merged, where=f"{at}negative")  # type: ignore[arg-type]
        if backward.size != values.size:
            raise LawError(f"{at}law '{law}': `negative` has another number of elements; give as many")
    return Friction(found, values, backward, gear_ratio, level or Level(), load_includes_rotor)
