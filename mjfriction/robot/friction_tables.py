"""What a robot.toml says of a joint's friction: its laws, and what varies them."""

from __future__ import annotations

from typing import Literal

from mjfriction.laws.ambient import ROOM_TEMPERATURE
from mjfriction.laws.friction import Friction, Level, friction
from mjfriction.laws.friction import Wave as LevelWave
from mjfriction.robot.table import Finite, Positive, Table, Wave


class LevelTable(Table):
    """What scales the level of a law, all but its linear damping, by 1 + the following.

    ``per_load``: 1/(N·m) or 1/N of the load on the law's side.  ``per_kelvin``: 1/K above ``reference_temperature``
    (°C).  ``waves``: shares that repeat along the stroke of the law's side.
    """

    per_load: Finite = 0.0
    per_kelvin: Finite = 0.0
    reference_temperature: Finite = ROOM_TEMPERATURE
    waves: tuple[Wave, ...] = ()


class FrictionTerm(Table):
    """One friction law on a joint; ``side`` is the side whose velocity and torque the law speaks of.

    ``negative`` are the parameters for motion backward, where they differ; ``level`` scales the law's level.  The load
    that a law reads is what passes the transmission to the links, with ``load_includes_rotor`` what the drive's rotor
    takes too.
    """

    law: str
    side: Literal["joint", "motor"] = "joint"
    parameters: dict[str, Finite | tuple[Finite, ...]]
    negative: dict[str, Finite | tuple[Finite, ...]] | None = None
    level: LevelTable = LevelTable()
    load_includes_rotor: bool = False

    def friction(self, gear_ratio: float, *, where: str = "") -> Friction:
        """Return the law as it stands at a joint whose drive has that gear ratio.

        Raises :class:`~mjfriction.errors.LawError`, ``where`` (the joint) in front, for what the law does not allow.
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
        """Return a parameter that is one number: forward and backward averaged, 0 where the law has none of it."""
        sets = [self.parameters, {**self.parameters, **(self.negative or {})}]
        found = [values.get(name, 0.0) for values in sets]
        return sum(0.0 if isinstance(value, tuple) else value for value in found) / len(sets)


class Thermal(Table):
    """Friction that follows the logged temperature: (``coulomb_per_kelvin`` · sgn q̇ + ``viscous_per_kelvin`` · q̇) times
    the temperature above ``reference_temperature`` (°C).
    """

    coulomb_per_kelvin: Finite = 0.0
    viscous_per_kelvin: Finite = 0.0
    reference_temperature: Finite = ROOM_TEMPERATURE


class WarmUp(Table):
    """Friction that settles with running time t (s): (``coulomb`` · sgn q̇ + ``viscous`` · q̇) · (1 − e^(−t/τ)), τ the
    ``time_constant``, t counted from ``begin`` on the log's clock.
    """

    coulomb: Finite = 0.0
    viscous: Finite = 0.0
    time_constant: Positive
    begin: Finite = 0.0


class Event(Table):
    """Friction that steps at a ``time`` of the log (s) and stays: ``coulomb`` · sgn q̇ + ``viscous`` · q̇ from then."""

    time: Finite
    coulomb: Finite = 0.0
    viscous: Finite = 0.0


class PressureFriction(Table):
    """Friction that the chambers press on: (``head`` · p₁ + ``rod`` · p₂ + ``difference`` · |p₁ − p₂|) · sgn q̇, N or
    N·m per Pa.
    """

    head: Finite = 0.0
    rod: Finite = 0.0
    difference: Finite = 0.0
