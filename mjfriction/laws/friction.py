"""A friction law with its values, as it stands at a joint."""

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

NUDGE = 1e-12  # rad or m, less than any spring in a joint yields at
CREEP = 1e-3  # rad/s or m/s on the law's side, below which friction has its level and next to no damping
SLOWEST, SPEEDS = 1e-4, 9  # share of a slow speed, and how many speeds from there on a law's level at rest is sought at


@dataclass(frozen=True, slots=True)
class Wave:
    """A share of the level that varies along the stroke: a·cos(kq) + b·sin(kq), k in 1/rad or 1/m."""

    wavenumber: float
    cosine: float
    sine: float


@dataclass(frozen=True, slots=True)
class Level:
    """What scales the level of a law: 1 + ``per_load``·|τ| + ``per_kelvin``·(T − T₀) + the waves.

    ``per_load`` in 1/(N·m) or 1/N of the law's side, ``per_kelvin`` in 1/K, ``reference_temperature`` T₀ in °C.
    """

    per_load: float = 0.0
    per_kelvin: float = 0.0
    reference_temperature: float = ROOM_TEMPERATURE
    waves: tuple[Wave, ...] = ()


@dataclass(frozen=True)
class Friction:
    """One law with its values, seen from the joint.

    ``law`` speaks of its own side of a gear: velocity there is ``gear_ratio`` times the joint's, and its torque comes
    back times the same.  ``level`` scales all of the law but its linear damping.  ``negative`` are the values for
    motion backward, where they differ; a law with them runs one copy for each direction.  The load that it reads is
    what passes the transmission to the links, or with ``load_includes_rotor`` all that the drive's rotor takes too.
    Make one with :func:`friction`.
    """

    law: Law
    values: Floats
    negative: Floats | None = None
    gear_ratio: float = 1.0
    level: Level = field(default=Level())
    load_includes_rotor: bool = False

    @property
    def state_count(self) -> int:
        """How many numbers the state has."""
        return self.law.state_count(self.values) * (1 if self.negative is None else 2)

    @functools.cached_property
    def packed(self) -> Floats:
        """The vector the compiled kernels read (:mod:`mjfriction.laws.wrapped` tells its layout)."""
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
        """Return what the law may hold while the joint rests, (n,): the most it gives at any speed up to ``slow``."""
        speeds = np.geomspace(SLOWEST * slow, slow, SPEEDS)
        ways = [np.full(ambient.shape[0], way * speed) for speed in speeds for way in (1.0, -1.0)]
        return np.asarray(np.max(np.abs([self.steady(way, ambient) for way in ways]), axis=0))

    def follow(self, velocity: Floats, ambient: Floats, h: float, state: Floats | None = None) -> tuple[Floats, Floats]:
        """Return the torque at the end of every step, (n,), and the state then, (n, states).

        ``velocity`` (n,) is the joint's velocity held during each step of ``h`` seconds; ``state`` is where the law
        starts, at rest without deflection when not given.
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
        """How far the joint moves until the law's springs have yielded (rad, m): its level at rest over its stiffness
        there, at room temperature and without load; infinite where nothing is held, 0 for a law without a state.
        """
        if self.state_count == 0:
            return 0.0
        # Moved and left there, so that what damps the springs adds nothing.
        held = self.follow(np.array([CREEP, 0.0]), ambient(2), NUDGE / CREEP)[0][1]
        level = self.at_rest(ambient(1), CREEP / abs(self.gear_ratio))[0]
        return float(NUDGE * level / held) if held > 0.0 else math.inf

    @functools.cached_property
    def _writable(self) -> Floats:
        # Compiled code knows read-only arrays as another type and would be compiled a second time for them.
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

    ``negative`` gives the values for motion backward; what it leaves out is as in ``parameters``.  With
    ``load_includes_rotor`` the load is counted with what the drive's rotor takes.  ``where`` (a joint, say) is put in
    front of messages.  Raises :class:`LawError` for an unknown law, values that the law does not allow,
    a negative set for a law that is not odd, or a gear ratio that is not a finite number other than 0.
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
