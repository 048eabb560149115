"""A robot for MuJoCo: its model file as a spec, and its friction as laws to attach."""

from __future__ import annotations

from mjfriction.errors import RobotError
from mjfriction.laws.coulomb_viscous import COULOMB_VISCOUS
from mjfriction.laws.friction import Friction, Level, friction
from mjfriction.laws.position_dependent import POSITION_DEPENDENT
from mjfriction.robot.body_tables import Payload, TakenUp
from mjfriction.robot.edges import edge_as_waves
from mjfriction.robot.friction import varies_along_stroke
from mjfriction.robot.robot import Robot
from mjfriction.robot.schema import Joint
from mjfriction.robot.spots import as_waves
from mjfriction.robot.spring import coefficients
from mjfriction.sim.spec import LinkMass, PointLoad, Spec, read_spec
from mjfriction.sim.springs import add_springs

PAYLOAD = "payload"
BESIDE = (
    "hydraulics",
    "cogging",
    "thermal",
    "warm_up",
    "events",
    "pressure_friction",
    "coupling",
    "common_drive",
    "transmission",
    "position_sensor",
    "effort_sensor",
)


def robot_spec(robot: Robot, *, with_taken_up: bool = False) -> Spec:
    """Read the model file as a MuJoCo spec with the robot's gravity, payload, links, rotors and springs built in.

    Friction is not included: :func:`mjfriction.attach` adds the laws of :func:`robot_laws`.  ``with_taken_up`` adds a
    massless body (``taken_up_0``, ``taken_up_1``, …) for each mass that the robot takes up.  Raises
    :class:`~mjfriction.errors.SimulationError` if MuJoCo cannot read the file.
    """
    table = robot.table
    loads = {} if table.payload is None else {PAYLOAD: _point_load(table.payload, table.payload.mass)}
    if with_taken_up:
        loads |= {name: _point_load(load, 0.0) for name, load in taken_up_bodies(robot).items()}
    spec = read_spec(
        robot.model_path,
        robot.joints,
        gravity=table.gravity,
        loads=loads,
        link_inertia={name: LinkMass(own.mass, own.com, own.inertia) for name, own in table.link_inertia.items()},
        link_scale=table.link_scale,
        link_shift=table.link_shift,
        rotor_inertia={j.name: j.actuator.reflected_inertia for j in table.joint},
    )
    add_springs(spec, {joint.name: coefficients(joint.spring) for joint in table.joint})
    return spec


def _point_load(held: Payload | TakenUp, mass: float) -> PointLoad:
    return PointLoad(mass, held.com, held.parent)


def taken_up_bodies(robot: Robot) -> dict[str, TakenUp]:
    """Return the masses that a robot takes up, by the names of their bodies in its spec."""
    return {f"taken_up_{k}": load for k, load in enumerate(robot.table.taken_up)}


def not_in_model(joint: Joint) -> list[str]:
    """Return the keys a joint states that neither its spec nor its laws contain; ``plant`` simulates them too."""
    plain = Joint(name=joint.name)
    ripple = ["actuator.ripple"] if joint.actuator.ripple else []
    return ripple + [key for key in BESIDE if getattr(joint, key) != getattr(plain, key)]


def in_model(robot: Robot) -> Robot:
    """Return the robot without the keys that neither its spec nor its laws contain."""
    joints = tuple(_in_model(joint) for joint in robot.table.joint)
    return Robot(robot.table.model_copy(update={"joint": joints, "held": None, "taken_up": ()}), robot.folder)


def _in_model(joint: Joint) -> Joint:
    plain = Joint(name=joint.name)
    beside = {key: getattr(plain, key) for key in BESIDE}
    actuator = joint.actuator.model_copy(update={"ripple": plain.actuator.ripple})
    return joint.model_copy(update={**beside, "actuator": actuator})


def robot_laws(robot: Robot) -> dict[str, list[Friction]]:
    """Return the friction laws that each joint states, as :func:`mjfriction.attach` takes them.

    Raises :class:`RobotError` for ``friction_waves``, ``friction_spots`` or ``friction_edges`` on a joint without a
    plain ``coulomb_viscous`` law on the joint's side.
    """
    laws = {joint.name: joint_laws(joint) for joint in robot.table.joint}
    return {name: own for name, own in laws.items() if own}


def joint_laws(joint: Joint) -> list[Friction]:
    """Return a joint's laws, with ``friction_waves``, ``friction_spots`` and ``friction_edges`` built into its
    Coulomb-viscous law.

    That law becomes a position-dependent one; spots and edges are expressed as waves.
    """
    laws = [term.friction(joint.actuator.gear_ratio) for term in joint.friction or ()]
    if not varies_along_stroke(joint):
        return laws
    places = [*map(as_waves, joint.friction_spots), *map(edge_as_waves, joint.friction_edges)]
    every = (*joint.friction_waves, *(wave for _, waves in places for wave in waves))
    for i, term in enumerate(joint.friction or ()):
        plain = term.side == "joint" and term.negative is None and laws[i].level == Level()
        if term.law == COULOMB_VISCOUS.name and plain:
            waves = {
                "wavenumber": [wave.wavenumber for wave in every],
                "cosine": [wave.cosine for wave in every],
                "sine": [wave.sine for wave in every],
            }
            coulomb = term.value("coulomb") + sum(level for level, _ in places)
            laws[i] = friction(POSITION_DEPENDENT.name, {**term.parameters, "coulomb": coulomb, **waves})
            return laws
    raise RobotError(
        f"joint '{joint.name}': friction_waves, friction_spots and friction_edges vary the level of a plain "
        "coulomb_viscous law on the joint's side, and it has none; add one (without `negative` and `level`; its "
        "coulomb may be 0)"
    )
