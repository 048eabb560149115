"""Tables of robot.toml for a joint's friction: its laws, and what varies them."""

from __future__ import annotations

from typing import Literal

from mjfriction.laws.ambient import ROOM_TEMPERATURE
from mjfriction.laws.friction import Friction, Level, friction
from mjfriction.laws.friction import Wave as LevelWave
from mjfriction.robot.table import Finite, Positive, Table, Wave


class LevelTable(Table):
    """A factor on the level of a law (all but its linear damping): 1 + the sum of the following.

    ``per_load``: 1/(N·m) or 1/N, times the load on the law's side.  ``per_kelvin``: 1/K, times the temperature above
    ``reference_temperature`` (°C).  ``waves``: relative variation along the stroke of the law's side.
    """

    per_load: Finite = 0.0
    per_kelvin: Finite = 0.0
    reference_temperature: Finite = ROOM_TEMPERATURE
    waves: tuple[Wave, ...] = ()


class FrictionTerm(Table):
    """One friction law on a joint; ``side`` is the side of the gear whose velocity and torque the law refers to.

    ``negative`` holds the parameters for backward motion where they differ; ``level`` scales the law's level.  The load
    that a law reads is the torque that passes the transmission to the links; with ``load_includes_rotor`` it includes
    the torque of the drive's rotor.
    """

    law: str
    side: Literal["joint", "motor"] = "joint"
    parameters: dict[str, Finite | tuple[Finite, ...]]
    negative: dict[str, Finite | tuple[Finite, ...]] | None = None
    level: LevelTable = LevelTable()
    load_includes_rotor: bool = False

    def friction(self, gear_ratio: float, *, where: str = "") -> Friction:
        """Return the law as seen from a joint whose drive has the given gear ratio.

        Raises :class:`~mjfriction.errors.LawError`, with ``where`` (the joint) in front, for values that the law does
        not allow.
        """
        waves = tuple(LevelWave(wave.wavenumber, wave.cosine, wave.sine) for wave in self.level.waves)
        level = Level(self.level.per_load, self.level.per_kelvin, self.level.reference_temperature, waves)
        ratio = gear_ratio if self.side == "motor" else 1.0
        return friction(
            self.law,
            self.parameters,
            negative=self.negative,
            gear_ratio=ratio,
            level=level,
            load_includes_rotor=self.load_includes_rotor,
            where=where,
        )

    def value(self, name: str) -> float:
        """Return a scalar parameter, averaged over the directions; 0 if the law has none of that name."""
        sets = [self.parameters, {**self.parameters, **(self.negative or {})}]
        found = [values.get(name, 0.0) for values in sets]
        return sum(0.0 if isinstance(value, tuple) else value for value in found) / len(sets)


class Thermal(Table):
    """Friction that depends on the logged temperature T (°C).

    (``coulomb_per_kelvin`` · sgn q̇ + ``viscous_per_kelvin`` · q̇) · (T − ``reference_temperature``).
    """

    coulomb_per_kelvin: Finite = 0.0
    viscous_per_kelvin: Finite = 0.0
    reference_temperature: Finite = ROOM_TEMPERATURE


class WarmUp(Table):
    """Friction that changes with running time t (s) and settles.

    (``coulomb`` · sgn q̇ + ``viscous`` · q̇) · (1 − e^(−t/τ)), where τ is the ``time_constant`` and t counts from
    ``begin`` on the log's clock.
    """

    coulomb: Finite = 0.0
    viscous: Finite = 0.0
    time_constant: Positive
    begin: Finite = 0.0


class Event(Table):
    """A lasting step of friction at a ``time`` of the log (s): ``coulomb`` · sgn q̇ + ``viscous`` · q̇ from then on."""

    time: Finite
    coulomb: Finite = 0.0
    viscous: Finite = 0.0


class PressureFriction(Table):
    """Friction that grows with the chamber pressures; the coefficients are N (or N·m) per Pa.

    (``head`` · p₁ + ``rod`` · p₂ + ``difference`` · |p₁ − p₂|) · sgn q̇.
    """

    head: Finite = 0.0
    rod: Finite = 0.0
    difference: Finite = 0.0
