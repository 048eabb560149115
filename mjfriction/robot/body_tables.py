"""Tables of robot.toml for links and held masses: mass, place and time."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from pydantic import ValidationInfo, field_validator

from mjfriction.robot.table import Finite, NonNegative, Positive, Table, Vector

# Tolerance of the check for physical moments of inertia, relative to their sum: numbers in a file are rounded.
ROUNDING = 1e-9


class Payload(Table):
    """A mass held by the arm: kg, and its centre (m) in the frame of ``parent``, a link or the joint that moves it."""

    mass: NonNegative
    com: Vector = (0.0, 0.0, 0.0)
    parent: str


class Place(Table):
    """Where a mass is held: ``com`` (m) in the frame of ``parent``, a link or the joint that moves it."""

    com: Vector = (0.0, 0.0, 0.0)
    parent: str


class TakenUp(Place):
    """A mass held for a while: kg in addition to the payload, negative where part of the payload is put down.

    It is held from ``begin`` to ``end`` on the log's clock (s), or to the log's end.
    """

    mass: Finite
    begin: Finite
    end: Finite | None = None

    @field_validator("end")
    @classmethod
    def _later(cls, value: float | None, told: ValidationInfo) -> float | None:
        begin = told.data.get("begin")
        if value is not None and begin is not None and value <= begin:
            raise ValueError(f"it begins at {begin:g} s; what is held ends after that, or has no end")
        return value


class LinkInertia(Table):
    """The inertia of the link that a joint moves.

    ``mass`` (kg), its centre ``com`` (m, from the joint along the axes of the link's frame) and ``inertia`` about that
    centre: xx, yy, zz, xy, xz, yz (kg·m²).
    """

    mass: Positive
    com: Vector
    inertia: tuple[Finite, Finite, Finite, Finite, Finite, Finite]

    @field_validator("inertia")
    @classmethod
    def _of_a_body(cls, value: tuple[float, ...]) -> tuple[float, ...]:
        if no_body_has(value):
            raise ValueError("no body has these moments: no principal moment may be more than the sum of the others")
        return value


def no_body_has(moments: Sequence[float]) -> bool:
    """Return whether no body has moments of inertia xx, yy, zz, xy, xz, yz about its centre: one of the principal
    moments is more than the sum of the others.
    """
    xx, yy, zz, xy, xz, yz = moments
    tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    least = float(np.linalg.eigvalsh(0.5 * np.trace(tensor) * np.eye(3) - tensor)[0])
    return least < -ROUNDING * abs(float(np.trace(tensor)))
