"""The voltage at the valve of a hydraulic cylinder: position control with and without acceleration feedback.

    volt = K_p·(x_d − x) + K_v·(v_d − v̂) + K_a·(a_d − â),   â = (u − F̂)/m,   u = A₁·p₁ − A₂·p₂ + other forces on m

Control law (15) of Bonchis, Ha, Corke and Rye is unreadable in print.  Its text says that the acceleration is computed
from friction known by the identified law or by an observer, that it is fed back in addition to position (after
Tafazoli, de Silva, Lawrence, IEEE Trans. Control Systems Technology 6(3), 1998), and that the gains may differ between
the directions.  Friction reaches the valve only through â: the pressures are driven to F̂ + m·a_d, which changes at a
reversal before a position error has built up.  With K_a = 0 this is the PD control that the paper compares with.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from mjfriction.body.inverse import inertia_at
from mjfriction.control.course import Course
from mjfriction.control.feedforward import feedforward_rigid
from mjfriction.control.observer import ObserverFor
from mjfriction.errors import ControlError
from mjfriction.laws.ambient import ambient
from mjfriction.laws.friction import Friction
from mjfriction.laws.law import Floats
from mjfriction.robot.robot import Robot


@dataclass(frozen=True)
class ValveGains:
    """``position`` K_p (V/m), ``velocity`` K_v (V·s/m), ``acceleration`` K_a (V·s²/m)."""

    position: float
    velocity: float = 0.0
    acceleration: float = 0.0

    def __post_init__(self) -> None:
        for name in ("position", "velocity", "acceleration"):
            value = getattr(self, name)
            if not (math.isfinite(value) and value >= 0.0):
                raise ControlError(f"valve gain {name} = {value:g}; allowed is 0 or above")


FrictionSource = tuple[Friction, ...] | ObserverFor
"""Where a controller knows friction from: laws at the joint, or (mass, step) → an observer."""


@dataclass(frozen=True)
class ValveControl:
    """Gains while the wanted motion extends and while it retracts, and the source of the friction in â.

    Laws are evaluated at the measured pressures and the estimated velocity; without ``friction``, F̂ is 0.
    ``velocity_bandwidth`` (Hz) is that of the filtered derivative that gives v̂.
    """

    extending: ValveGains
    retracting: ValveGains
    friction: FrictionSource | None = None
    velocity_bandwidth: float = 40.0


class ValveDrive:
    """The controller of one valve: a function of the step and the readings of position and chamber pressures.

    ``wanted`` is the wanted position, velocity and acceleration, (n,) each; ``beside`` (n,) are the forces on the
    ``mass`` other than oil and friction; ``areas`` are the piston's, m².  The friction estimate that it uses is written
    into ``estimates`` (n,).
    """

    def __init__(
        self,
        control: ValveControl,
        areas: tuple[float, float],
        mass: float,
        wanted: tuple[Floats, Floats, Floats],
        beside: Floats,
        step: float,
        estimates: Floats,
    ) -> None:
        self.control, self.areas, self.mass, self.step = control, areas, mass, step
        self.place, self.speed, self.rate = wanted
        self.beside = beside
        self.share = -math.expm1(-2.0 * math.pi * control.velocity_bandwidth * step)
        self.last, self.velocity = float(self.place[0]), 0.0
        self.observer = control.friction(mass, step) if callable(control.friction) else None
        if self.observer is not None:
            self.observer.check_step(step)
            self.known = self.observer.start(self.last)
        self.laws = control.friction if isinstance(control.friction, tuple) else ()
        self.estimates = estimates

    def __call__(self, k: int, position: float, head: float, rod: float) -> float:
        """Return the voltage at step ``k``, V."""
        self.velocity += self.share * ((position - self.last) / self.step - self.velocity)
        self.last = position
        force = self.areas[0] * head - self.areas[1] * rod + float(self.beside[k])
        friction, velocity = 0.0, self.velocity
        if self.observer is not None:
            self.known, friction, velocity = self.observer.step(self.known, position, velocity, force, self.step)
        elif self.laws:
            around = ambient(1, position=position, pressure_head=head, pressure_rod=rod)
            at = np.array([velocity])
            friction = sum(float(law.steady(at, around)[0]) for law in self.laws)
        self.estimates[k] = friction
        gains = self.control.extending if self.speed[k] >= 0.0 else self.control.retracting
        return float(
            gains.position * (self.place[k] - position)
            + gains.velocity * (self.speed[k] - velocity)
            + gains.acceleration * (self.rate[k] - (force - friction) / self.mass)
        )


def valve_drive(
    robot: Robot, joint: int, control: ValveControl, course: Course, step: float, estimates: Floats
) -> ValveDrive:
    """Return the controller of the valve that moves a joint along a course whose rows are ``step`` seconds apart.

    ``robot`` is the controller's model; the friction estimate that it uses is written into ``estimates`` (n,).
    """
    of = robot.table.joint[joint].hydraulics
    assert of is not None, "a joint with a valve"
    mass = float(inertia_at(robot.body(), course.position[0])[joint])
    wanted = (course.position[:, joint], course.velocity[:, joint], course.acceleration[:, joint])
    beside = mass * wanted[2] - feedforward_rigid(robot, "dynamics", course)[:, joint]
    return ValveDrive(control, (of.head_area, of.rod_area), mass, wanted, beside, step, estimates)
