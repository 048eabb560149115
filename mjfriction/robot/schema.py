"""What a robot.toml may hold: the keys, their types and their bounds."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import BeforeValidator, Field, ValidationInfo, field_validator

from mjfriction.robot.body_tables import LinkInertia, Payload, Place, TakenUp
from mjfriction.robot.friction_tables import Event, FrictionTerm, PressureFriction, Thermal, WarmUp
from mjfriction.robot.table import Finite, NonNegative, Positive, Spot, Table, Vector, Wave


def _as_list(value: Any) -> Any:
    return [value] if isinstance(value, dict) else value


class Actuator(Table):
    """The drive of a joint.

    ``gear_ratio``: motor radians per joint radian (per metre on a sliding joint), negative where the motor turns
    against the joint.  ``torque_constant``: N·m/A at the motor.  ``rotor_inertia``: kg·m² at the motor.
    ``current_limit``: A, where the drive saturates.  ``current_bandwidth``: Hz of the loop that makes the current,
    which in a simulation lags what the controller asks for.  ``ripple``: by what share of itself the torque of a given
    current varies along the stroke.
    """

    gear_ratio: Finite = 1.0
    torque_constant: Positive | None = None
    rotor_inertia: NonNegative = 0.0
    current_limit: Positive | None = None
    current_bandwidth: Positive | None = None
    ripple: tuple[Wave, ...] = ()

    @property
    def reflected_inertia(self) -> float:
        """``rotor_inertia`` · ``gear_ratio``²: what the joint feels of the rotor, kg·m² or kg."""
        return self.rotor_inertia * self.gear_ratio**2

    @property
    def effort_per_ampere(self) -> float | None:
        """``gear_ratio`` · ``torque_constant``: effort at the joint for a current, N·m/A or N/A; none where not stated.

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
    """A cylinder that moves a sliding joint: double acting, its rod on one side, its valve proportional.

    effort = ``head_area``·p₁ − ``rod_area``·p₂ (m²; Pa above the tank).  ``head_volume``, ``rod_volume``: oil in each
    chamber and its hose with the joint at zero, m³; ``bulk_modulus``: of the oil, Pa; ``hose_compliance``: m³/Pa of
    each hose; ``leakage``: past the piston, m³/(s·Pa).  Valve: ``rated_flow`` (m³/s) at ``voltage_limit`` (V) and
    ``rated_drop`` (Pa) over one edge, ``valve_bandwidth`` (Hz) of its spool.  ``supply_pressure``: Pa.
    ``pressure_resolution`` and ``pressure_noise`` (Pa) shape what a simulation reports.
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

    With ``bandwidth`` (Hz) the effort is low-passed there: a Butterworth of fourth order forward and backward, which
    shifts nothing in time; what a drive's own filter adds to that is ``delay``.  ``resolution`` and ``noise`` (its
    standard deviation) shape what a simulation reports.
    """

    scale: Positive = 1.0
    offset: Finite = 0.0
    delay: Finite = 0.0
    bandwidth: Positive | None = None
    resolution: NonNegative = 0.0
    noise: NonNegative = 0.0


class Spring(Table):
    """A spring on a joint: ``preload`` + ``stiffness`` · q + ``quadratic`` · q² + ``cubic`` · q³, the last two for
    balancers and hoses whose torque bends along the stroke.
    """

    stiffness: Finite = 0.0
    preload: Finite = 0.0
    quadratic: Finite = 0.0
    cubic: Finite = 0.0


class Coupling(Table):
    """What another joint's motion or effort adds to this joint's effort through the transmission.

    ``coulomb`` · sgn q̇ₖ + ``viscous`` · q̇ₖ + ``inertia`` · q̈ₖ + ``effort`` · effortₖ, k being the other ``joint``.
    """

    joint: str
    coulomb: Finite = 0.0
    viscous: Finite = 0.0
    inertia: Finite = 0.0
    effort: Finite = 0.0


class CommonDrive(Table):
    """A drive that turns with q̇ + ``ratio`` · q̇ₖ = u, k being the other ``joint``, as in coupled wrists.

    F = ``coulomb`` · sgn u + ``viscous`` · u + ``inertia`` · u̇ acts on this joint, ``ratio`` · F on the other.
    """

    joint: str
    ratio: Finite
    coulomb: Finite = 0.0
    viscous: Finite = 0.0
    inertia: NonNegative = 0.0


class Transmission(Table):
    """What lies between the position sensor, on the motor's side, and the link.

    The link lags the sensor by ``compliance`` · load + ½ · ``backlash`` · sgn(load): rad/(N·m) and rad (m/N and m).
    With ``damping_ratio``, of critical, it swings on its compliance, else it follows its load at once.
    With ``coasting`` the link crosses its play by its own inertia when the load changes sign, else as the load says:
    tanh(load / ``crossing_load``) in place of sgn(load), at once where that is 0.  With ``carries_friction`` the
    joint's friction acts on the link's side and belongs to the load; with ``rubs_with_link`` it acts there and does
    not, as where it is the sensor's mount that gives.
    """

    compliance: NonNegative = 0.0
    damping_ratio: Positive | None = None
    backlash: NonNegative = 0.0
    coasting: bool = True
    crossing_load: NonNegative = 0.0
    carries_friction: bool = False
    rubs_with_link: bool = False

    @property
    def jump(self) -> float:
        """By how much the sensor jumps as the load changes sign, rad or m: play that is crossed at once."""
        return 0.0 if self.coasting or self.crossing_load > 0.0 else self.backlash

    @property
    def gives(self) -> bool:
        """Whether the link is anywhere but at its sensor."""
        return self.compliance > 0.0 or self.backlash > 0.0

    @property
    def jump_free(self) -> Transmission:
        """The transmission without what makes its sensor jump."""
        return self.model_copy(update={"backlash": self.backlash - self.jump})


class PositionSensor(Table):
    """What the position sensor reads: position + ``offset``.

    ``resolution``, ``noise`` and ``velocity_noise`` (standard deviations) shape what a simulation reports.  With
    ``velocity_bandwidth`` (Hz) the velocity it reports is the drive's estimate: the difference of the positions read,
    through a low-pass of first order.
    """

    offset: Finite = 0.0
    resolution: NonNegative = 0.0
    noise: NonNegative = 0.0
    velocity_noise: NonNegative = 0.0
    velocity_bandwidth: Positive | None = None


class Joint(Table):
    """One joint.

    Several friction laws add up; without any, the model file's own damping and dry friction hold.  ``friction_waves``,
    ``friction_spots``, ``thermal``, ``warm_up``, ``events`` and ``pressure_friction`` add to them against the motion;
    ``cogging`` and ``spring`` do not turn with its direction.  ``top_speed`` (rad/s, m/s) bounds planned motions, in
    the place of the model file's own.
    """

    name: str
    top_speed: Positive | None = None
    actuator: Actuator = Actuator()
    hydraulics: Hydraulics | None = None
    friction: Annotated[tuple[FrictionTerm, ...], BeforeValidator(_as_list)] | None = None
    friction_waves: tuple[Wave, ...] = ()
    friction_spots: tuple[Spot, ...] = ()
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

    ``held`` is where the arm holds what logs speak of in their column ``held_mass``; ``taken_up`` is what it holds
    besides for a while.  For links, each named by the joint that moves it: ``link_inertia`` takes the place of what the
    model says; ``link_shift`` is by how much the centre of mass lies elsewhere, m along the axes of the link's frame;
    ``link_scale`` is what multiplies the mass and inertia, a payload on the link included.
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
