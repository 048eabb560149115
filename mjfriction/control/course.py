"""The wanted motion of the joints."""

from __future__ import annotations

from dataclasses import dataclass

from mjfriction.laws.law import Floats


@dataclass(frozen=True)
class Course:
    """A wanted motion at every step: position, velocity, acceleration, each (n, joints)."""

    position: Floats
    velocity: Floats
    acceleration: Floats
