"""A law's portrait: four plots that show how the laws differ."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mjfriction.laws.ambient import LOAD, POSITION, PRESSURE_HEAD, TEMPERATURE, ambient
from mjfriction.laws.law import Floats, Law
from mjfriction.laws.rules import BreakawayOrder, Ordering, SumIsOne, SumReaches, Values, scalar

ELEMENTS = 4
STEPS = 4000
OTHER_WAY = ("_negative", "_braking", "_retracting")


@dataclass(frozen=True)
class Curve:
    """A curve of a plot: ``x`` and ``torque`` (n,), and its name."""

    name: str
    x: Floats
    torque: Floats


@dataclass(frozen=True)
class Portrait:
    """The four plots of a law.

    ``steady``: steady torque against velocity, at three ambient conditions if the law depends on them.
    ``presliding``: torque against travel before slip, with an inner loop.  ``lag``: torque against velocity while the
    sliding speed oscillates at three frequencies.  ``breakaway``: torque against travel from rest at three speeds.
    """

    steady: tuple[Curve, ...]
    presliding: tuple[Curve, ...]
    lag: tuple[Curve, ...]
    breakaway: tuple[Curve, ...]


def typical_values(law: Law, elements: int = ELEMENTS) -> dict[str, float | tuple[float, ...]]:
    """Return a plausible set of values for a law: the middle of its typical ranges, adjusted to satisfy its rules."""
    values = {p.name: p.default if p.default is not None else 0.5 * sum(p.typical) for p in law.parameters}
    scalars = {name: float(value) for name, value in values.items()}
    for name in scalars:
        if name.endswith(OTHER_WAY):  # otherwise both directions would be the same
            scalars[name] *= 1.5
    for rule in law.rules:
        if isinstance(rule, Ordering):
            scalars[rule.larger] = 1.5 * scalars[rule.smaller]
    ranges = {p.name: p.typical for p in law.elements}
    arrays = {name: np.linspace(low, high, elements) for name, (low, high) in ranges.items()}
    for rule in law.rules:
        if isinstance(rule, BreakawayOrder):
            low, high = ranges[rule.stiffness]
            arrays[rule.stiffness] = np.geomspace(high, low, elements)
        if isinstance(rule, SumIsOne):
            arrays[rule.share] = arrays[rule.share] / np.sum(arrays[rule.share])
        if isinstance(rule, SumReaches):
            arrays[rule.level] *= max(1.0, 1.01 * scalars[rule.floor] / float(np.sum(arrays[rule.level])))
    return {**scalars, **{name: tuple(own.tolist()) for name, own in arrays.items()}}


def portrait(law: Law, values: Values | None = None) -> Portrait:
    """Return the portrait of a law with these values, or with typical ones."""
    values = typical_values(law) if values is None else values
    packed = law.pack(values)
    fall = _fall_velocity(values)
    v = np.linspace(-10.0 * fall, 10.0 * fall, 801)
    steady = [Curve(name, v, law.along(v, around, packed)) for name, around in _surroundings(law, v.size)]

    def drawn(corners: list[float], speed: float, name: str) -> Curve:
        path = np.cumsum(np.abs(np.diff(corners)))
        along = np.linspace(0.0, path[-1], STEPS)
        x = np.interp(along, [0.0, *path], corners)
        h = along[1] / speed
        velocity = np.diff(x, prepend=x[0]) / h
        return Curve(name, x, law.follow(velocity, ambient(STEPS), h, packed)[0])

    slow = 1e-4 * fall
    reach = _breakaway_travel(law, packed, slow)
    loop = drawn([0.0, reach, -reach, 0.2 * reach, -0.3 * reach, 0.2 * reach, reach], slow, "slow, with an inner loop")
    lag = []
    for share in (0.02, 0.1, 0.5):
        frequency = share * fall / reach
        t = np.linspace(0.0, 4.0 / frequency, STEPS)
        velocity = fall * (1.0 + 0.9 * np.sin(2.0 * np.pi * frequency * t))
        begin = np.full(STEPS, velocity[0])
        sliding = law.follow(begin, ambient(STEPS), 20.0 * reach / fall / STEPS, packed)[1][-1]
        torque = law.follow(velocity, ambient(STEPS), t[1], packed, sliding)[0]
        last = t >= 3.0 / frequency
        lag.append(Curve(f"{frequency:.2g} Hz", velocity[last], torque[last]))
    away = [drawn([0.0, 2.0 * reach], speed, f"{speed:.2g} rad/s") for speed in (0.01 * fall, 0.3 * fall, 3.0 * fall)]
    return Portrait(tuple(steady), (loop,), tuple(lag), tuple(away))


def _surroundings(law: Law, count: int) -> list[tuple[str, Floats]]:
    # Three ambient conditions for a law that depends on them, otherwise one.
    if LOAD in law.reads:
        return [(f"load {load:g} N·m", ambient(count, load=load)) for load in (0.0, 25.0, 50.0)]
    if TEMPERATURE in law.reads:
        return [(f"{degrees:g} °C", ambient(count, temperature=degrees)) for degrees in (10.0, 25.0, 40.0)]
    if POSITION in law.reads:
        return [(f"position {place:g} rad", ambient(count, position=place)) for place in (0.0, 0.1, 0.2)]
    if PRESSURE_HEAD in law.reads:
        return [(f"head {bar:g} bar", ambient(count, pressure_head=1e5 * bar)) for bar in (0.0, 20.0, 40.0)]
    return [("steady", ambient(count))]


def _fall_velocity(values: Values) -> float:
    if "stribeck_velocity" in values:
        return scalar(values, "stribeck_velocity")
    return 1.0 / scalar(values, "stribeck_steepness") if "stribeck_steepness" in values else 0.1


def _breakaway_travel(law: Law, packed: Floats, speed: float) -> float:
    # Twice the travel after which more than 90 % of the steady torque is reached.
    level = abs(law.steady(speed, ambient(1)[0], packed))
    travel = 1e-9
    if law.state_count(packed) == 0:
        return 1e-3
    while travel < 1.0:
        h = travel / speed / STEPS
        if law.follow(np.full(STEPS, speed), ambient(STEPS), h, packed)[0][-1] > 0.9 * level:
            break
        travel *= 1.5
    return 2.0 * travel
