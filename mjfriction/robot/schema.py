"""The schema of robot.toml: its keys, their types and their bounds."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import BeforeValidator, Field, ValidationInfo, field_validator

from mjfriction.robot.body_tables import LinkInertia, Payload, Place, TakenUp
from mjfriction.robot.friction_tables import Event, FrictionTerm, PressureFriction, Thermal, WarmUp
from mjfriction.robot.table import Edge, Finite, NonNegative, Positive, Spot, Table, Vector, Wave


def _as_list(value: Any) -> Any:
    return [value] if isinstance(value, dict) else value


class Actuator(Table):
    """The drive of a joint.

    ``gear_ratio``: motor radians per joint radian (per metre on a sliding joint), negative where the motor turns
    against the joint.  ``torque_constant``: N·m/A at the motor.  ``rotor_inertia``: kg·m² at the motor.
    ``current_limit``: A, where the drive saturates.  ``current_bandwidth``: Hz, bandwidth of the current loop; in a
    simulation the current lags the command accordingly.  ``ripple``: the relative variation along the stroke of the
    torque that a given current produces.
    """

    gear_ratio: Finite = 1.0
    torque_constant: Positive | None = None
    rotor_inertia: NonNegative = 0.0
    current_limit: Positive | None = None
    current_bandwidth: Positive | None = None
    ripple: tuple[Wave, ...] = ()

    @property
    def reflected_inertia(self) -> float:
        """``rotor_inertia`` · ``gear_ratio``²: the rotor's inertia reflected to the joint, kg·m² or kg."""
        return self.rotor_inertia * self.gear_ratio**2

    @property
    def effort_per_ampere(self) -> float | None:
        """``gear_ratio`` · ``torque_constant``: effort at the joint per ampere, N·m/A or N/A; None if not stated.

        Negative where the motor turns against the joint.
        """
        return None if self.torque_constant is None else self.gear_ratio * self.torque_constant

    @field_validator("gear_ratio")
    @classmethod
    def _turns(cls, value: float) -> float:
        if value == 0.0:
            raise ValueError("a gear ratio of 0 moves nothing; give motor radians per joint radian")
        return value

    @field_validator("ripple")
    @classmethod
    def _pushes(cls, value: tuple[Wave, ...]) -> tuple[Wave, ...]:
        if sum(abs(wave.cosine) + abs(wave.sine) for wave in value) >= 1.0:
            raise ValueError("a ripple of 1 or more would turn the drive's torque over; give shares of the torque")
        return value


class Hydraulics(Table):
    """A hydraulic cylinder that moves a sliding joint: double-acting, single-rod, with a proportional valve.

    effort = ``head_area``·p₁ − ``rod_area``·p₂ (m²; Pa above the tank).  ``head_volume``, ``rod_volume``: oil in each
    chamber and its hose with the joint at zero, m³; ``bulk_modulus``: of the oil, Pa; ``hose_compliance``: m³/Pa of
    each hose; ``leakage``: past the piston, m³/(s·Pa).  Valve: ``rated_flow`` (m³/s) at ``voltage_limit`` (V) and
    ``rated_drop`` (Pa) over one edge, ``valve_bandwidth`` (Hz) of its spool.  ``supply_pressure``: Pa.
    ``pressure_resolution`` and ``pressure_noise`` (Pa) only affect simulated readings.
    """

    head_area: Positive
    rod_area: Positive
    head_volume: Positive
    rod_volume: Positive
    bulk_modulus: Positive = 1.4e9
    hose_compliance: NonNegative = 0.0
    leakage: NonNegative = 0.0
    rated_flow: Positive
    rated_drop: Positive = 3.5e6
    voltage_limit: Positive = 10.0
    valve_bandwidth: Positive = 60.0
    supply_pressure: Positive
    pressure_resolution: NonNegative = 0.0
    pressure_noise: NonNegative = 0.0


class EffortSensor(Table):
    """What the drive reports: ``scale`` · effort(t − ``delay``) + ``offset`` (s; N·m or N at the joint).

    With ``bandwidth`` (Hz) the effort is low-passed at that frequency by a fourth-order Butterworth filter, applied
    forward and backward so that it adds no lag; the lag of a drive's own filter belongs to ``delay``.  ``resolution``
    and ``noise`` (standard deviation) only affect simulated readings.
    """

    scale: Positive = 1.0
    offset: Finite = 0.0
    delay: Finite = 0.0
    bandwidth: Positive | None = None
    resolution: NonNegative = 0.0
    noise: NonNegative = 0.0


class Spring(Table):
    """A spring on a joint: ``preload`` + ``stiffness`` · q + ``quadratic`` · q² + ``cubic`` · q³.

    The last two terms are for balancers and hoses whose torque is not linear in position.
    """

    stiffness: Finite = 0.0
    preload: Finite = 0.0
    quadratic: Finite = 0.0
    cubic: Finite = 0.0


class Coupling(Table):
    """What another joint's motion or effort adds to this joint's effort through the transmission.

    ``coulomb`` · sgn q̇ₖ + ``viscous`` · q̇ₖ + ``inertia`` · q̈ₖ + ``effort`` · effortₖ; k is the other ``joint``.
    """

    joint: str
    coulomb: Finite = 0.0
    viscous: Finite = 0.0
    inertia: Finite = 0.0
    effort: Finite = 0.0


class CommonDrive(Table):
    """A drive shared by two joints, as in coupled wrists.

    It turns at u = q̇ + ``ratio`` · q̇ₖ, where k is the other ``joint``.  F = ``coulomb`` · sgn u + ``viscous`` · u +
    ``inertia`` · u̇ acts on this joint, ``ratio`` · F on the other.
    """

    joint: str
    ratio: Finite
    coulomb: Finite = 0.0
    viscous: Finite = 0.0
    inertia: NonNegative = 0.0


class Transmission(Table):
    """The elasticity and play between the position sensor, on the motor's side, and the link.

    The link lags the sensor by ``compliance`` · load + ½ · ``backlash`` · sgn(load): rad/(N·m) and rad (m/N and m).
    With ``hardening`` (N·m/rad³ or N/m³) its spring stiffens: load = s/``compliance`` + ``hardening`` · s³ over the
    lag s.  With ``damping_ratio`` (relative to critical damping at the link's usual inertia along a motion) the
    link oscillates on its compliance; without it, the deflection follows the load without delay.  With ``coasting``
    the link crosses its play by its own inertia when the load changes sign; where it oscillates too, it flies
    between flanks that give.  Without, the load sets its place in the play: tanh(load / ``crossing_load``) replaces
    sgn(load), and the link crosses instantly where ``crossing_load`` is 0.  With ``carries_friction`` the joint's
    friction acts on the link's side and is part of the load; with ``rubs_with_link`` it acts on the link's side but
    is not part of the load, as when it is the sensor's mount that is compliant.
    """

    compliance: NonNegative = 0.0
    hardening: NonNegative = 0.0
    damping_ratio: Positive | None = None
    backlash: NonNegative = 0.0
    coasting: bool = True
    crossing_load: NonNegative = 0.0
    carries_friction: bool = False
    rubs_with_link: bool = False

    @property
    def jump(self) -> float:
        """How far the sensor jumps when the load changes sign, rad or m: play that is crossed instantly."""
        return 0.0 if self.coasting or self.crossing_load > 0.0 else self.backlash

    @property
    def swings(self) -> bool:
        """Whether the link oscillates on its compliance."""
        return self.compliance > 0.0 and self.damping_ratio is not None

    @property
    def gives(self) -> bool:
        """Whether the link may deviate from its sensor's position."""
        return self.compliance > 0.0 or self.backlash > 0.0

    @property
    def jump_free(self) -> Transmission:
        """The transmission without the play that makes its sensor jump."""
        return self.model_copy(update={"backlash": self.backlash - self.jump})


class PositionSensor(Table):
    """What the position sensor reads: position + ``offset``.

    ``resolution``, ``noise`` and ``velocity_noise`` (standard deviations) only affect simulated readings.  With
    ``velocity_bandwidth`` (Hz) the simulated velocity is the drive's estimate: differences of the positions read,
    through a first-order low-pass.
    """

    offset: Finite = 0.0
    resolution: NonNegative = 0.0
    noise: NonNegative = 0.0
    velocity_noise: NonNegative = 0.0
    velocity_bandwidth: Positive | None = None


class Joint(Table):
    """One joint.

    Several friction laws add up; without any, the model file's own damping and dry friction apply.  ``friction_waves``,
    ``friction_spots``, ``friction_edges``, ``thermal``, ``warm_up``, ``events`` and ``pressure_friction`` add to them
    and act against the motion; ``cogging`` and ``spring`` do not depend on its direction.  ``top_speed`` (rad/s, m/s)
    bounds planned motions and replaces the model file's own limit.
    """

    name: str
    top_speed: Positive | None = None
    actuator: Actuator = Actuator()
    hydraulics: Hydraulics | None = None
    friction: Annotated[tuple[FrictionTerm, ...], BeforeValidator(_as_list)] | None = None
    friction_waves: tuple[Wave, ...] = ()
    friction_spots: tuple[Spot, ...] = ()
    friction_edges: tuple[Edge, ...] = ()
    cogging: tuple[Wave, ...] = ()
    spring: Spring = Spring()
    thermal: Thermal = Thermal()
    warm_up: WarmUp | None = None
    events: tuple[Event, ...] = ()
    pressure_friction: PressureFriction = PressureFriction()
    coupling: tuple[Coupling, ...] = ()
    common_drive: tuple[CommonDrive, ...] = ()
    transmission: Transmission = Transmission()
    position_sensor: PositionSensor = PositionSensor()
    effort_sensor: EffortSensor = EffortSensor()

    def model_post_init(self, _context: Any, /) -> None:
        """Check the friction laws against their declarations."""
        for term in self.friction or ():
            term.friction(self.actuator.gear_ratio, where=f"joint '{self.name}'")


class RobotTable(Table):
    """A whole robot file.

    ``held`` is the place where the arm holds the mass that logs report in their column ``held_mass``; ``taken_up``
    lists masses that it holds in addition for a while.  Links are named by the joint that moves them: ``link_inertia``
    replaces the model file's mass and inertia; ``link_shift`` displaces the centre of mass, m along the axes of the
    link's frame; ``link_scale`` multiplies the mass and inertia, including a payload on the link.
    """

    name: str
    model: str
    gravity: Vector | None = None
    payload: Payload | None = None
    held: Place | None = None
    taken_up: tuple[TakenUp, ...] = ()
    link_inertia: dict[str, LinkInertia] = Field(default_factory=dict)
    link_scale: dict[str, Positive] = Field(default_factory=dict)
    link_shift: dict[str, Vector] = Field(default_factory=dict)
    joint: tuple[Joint, ...] = Field(min_length=1)

    @field_validator("taken_up")
    @classmethod
    def _of_a_payload(cls, value: tuple[TakenUp, ...], told: ValidationInfo) -> tuple[TakenUp, ...]:
        if told.data.get("payload") is None and any(load.mass < 0.0 for load in value):
            raise ValueError("a mass below 0 puts a payload down, and none is stated")
        return value

    @field_validator("joint")
    @classmethod
    def _distinct(cls, value: tuple[Joint, ...]) -> tuple[Joint, ...]:
        names = [joint.name for joint in value]
        doubled = sorted({name for name in names if names.count(name) > 1})
        if doubled:
            raise ValueError(f"joint '{doubled[0]}' is listed twice; list every joint once")
        for joint in value:
            for other in [one.joint for one in joint.coupling] + [one.joint for one in joint.common_drive]:
                if other not in names or other == joint.name:
                    raise ValueError(
                        f"joint '{joint.name}' is coupled to '{other}'; it must be another of {', '.join(names)}"
                    )
        return value
