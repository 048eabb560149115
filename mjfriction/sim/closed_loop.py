"""A model run step by step under its drives and the passive torques against them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import NamedTuple

import mujoco
import numpy as np
from numpy.typing import NDArray

from mjfriction.errors import SimulationError
from mjfriction.laws.law import Floats
from mjfriction.progress import Tell, silently
from mjfriction.sim.attach import Laws, attach, rewrite
from mjfriction.sim.callback import friction_active
from mjfriction.sim.messages import messages_dropped
from mjfriction.sim.reading import BROKEN, read_friction
from mjfriction.sim.spec import compiled
from mjfriction.sim.transmission import DeadZone, behind_stops, give_places, sag

SETTLING = 0.5  # s before the run, in which transmissions that give come to rest under their load
TELLING = 5000  # steps between progress reports of a run


@dataclass(frozen=True)
class Played:
    """What the joints did, at the beginning of every step.

    Motor-side position and velocity, drive torque, friction through the step, and position of the links, each
    (n, joints).  ``states`` are the states of the friction laws by joint, (n, states), where they were requested;
    ``touching`` is whether any shapes touched each other, (n,), and ``stopped`` which joints were beyond a stop of
    their range, (n, joints).
    """

    position: Floats
    velocity: Floats
    torque: Floats
    friction: Floats
    link_position: Floats
    states: dict[str, Floats]
    touching: NDArray[np.bool_]
    stopped: NDArray[np.bool_]


class Around(NamedTuple):
    """The surroundings of the joints, (joints,) each.

    Friction laws read ``warmth`` (kelvin above 25 °C) and the chamber pressures (Pa); ``push`` is an external push, N·m
    or N.
    """

    warmth: Floats
    pressure_head: Floats
    pressure_rod: Floats
    push: Floats


Drive = Callable[[int, Floats, Floats], Floats]
"""(step, position, velocity) → what the drives push with through that step, (joints,), N·m or N."""

Passive = Callable[[Floats, Floats, Floats, Floats], Floats]
"""(position, velocity, the last step's acceleration, drive torque) → torque that stands against the drives at the
joints, (joints,).
"""


def play(
    spec: mujoco.MjSpec,
    joints: tuple[str, ...],
    laws: Laws,
    start: Floats,
    drive: Drive,
    count: int,
    step: float,
    *,
    dead_zones: Mapping[str, DeadZone] | None = None,
    passive: Passive | None = None,
    around: Callable[[int], Around] | None = None,
    laws_at: Callable[[int], Laws | None] | None = None,
    masses_at: Callable[[int], Mapping[str, float] | None] | None = None,
    whole: bool = False,
    tell: Tell = silently,
) -> Played:
    """Run a model for a number of steps and return what happened at the beginning of every one.

    ``start`` is position and velocity (2, joints).  The torque of a step is held through it.  ``dead_zones`` act in the
    transmissions of joints that were split.  ``around`` is called, after the drive, for the joints' surroundings.
    ``laws_at`` may return other laws (of the same kinds) that apply from a step on, ``masses_at`` other masses (kg) of
    bodies.  With ``whole`` the states of the friction laws are recorded.  ``tell`` receives progress reports.

    Raises :class:`SimulationError` when the run diverges, with the joint and the time.
    """
    spec.option.timestep = step
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    model = attach(spec, laws) if laws else compiled(spec)
    data = mujoco.MjData(model)
    places = np.array([model.jnt_qposadr[model.joint(name).id] for name in joints])
    dofs = np.array([model.jnt_dofadr[model.joint(name).id] for name in joints])
    gives = give_places(model, joints)
    press = behind_stops(model, dead_zones or {})
    reader = read_friction(model) if laws else None
    rubbing = np.array([joints.index(name) for name in reader.joints]) if reader else np.array([], dtype=int)
    data.qpos[places], data.qvel[dofs] = start
    sag(model, data, gives, {joints.index(name): zone for name, zone in (dead_zones or {}).items()})
    settling = round(SETTLING / step) if gives else 0
    blank = np.zeros((count, len(joints)))
    kept = {name: reader.state(name) for name in reader.joints} if reader and whole else {}
    states = {name: np.empty((count, place.stop - place.start)) for name, place in kept.items()}
    touching, stopped = np.zeros(count, dtype=bool), np.zeros(blank.shape, dtype=bool)
    out = Played(blank, blank.copy(), blank.copy(), blank.copy(), blank.copy(), states, touching, stopped)
    applied, acceleration = np.zeros(model.nv), np.zeros(len(joints))
    with friction_active(), messages_dropped():
        for step_number in range(-settling, count):
            if step_number % TELLING == 0:
                tell("simulating", max(step_number, 0) / count)
            k = max(step_number, 0)  # while settling, the drives stay at the beginning of their course
            position, velocity = data.qpos[places], data.qvel[dofs]
            torque = drive(k, position, velocity)
            out.position[k], out.velocity[k], out.torque[k] = position, velocity, torque
            out.link_position[k] = position
            for i, place in gives.items():
                out.link_position[k, i] += data.qpos[place]
            applied[dofs] = torque - (passive(position, velocity, acceleration, torque) if passive else 0.0)
            data.qfrc_applied[:] = applied
            press(data)
            now = None if around is None else around(k)
            if now is not None:
                data.qfrc_applied[dofs] += now.push
            if now is not None and reader is not None:
                data.userdata[reader.warmth] = now.warmth[rubbing]
                data.userdata[reader.pressure_head] = now.pressure_head[rubbing]
                data.userdata[reader.pressure_rod] = now.pressure_rod[rubbing]
            changed = laws_at and laws_at(k)
            if changed:
                rewrite(model, changed)
            for name, mass in ((masses_at and masses_at(k)) or {}).items():
                _weigh(model, name, mass)
            _advance(model, data, k * step)
            acceleration = data.qacc[dofs]
            out.touching[k], out.stopped[k] = np.any(data.contact.efc_address >= 0), _at_a_stop(model, data)[dofs]
            if reader is not None:
                out.friction[k, rubbing] = data.userdata[reader.torque]
                for name, own in kept.items():
                    states[name][k] = data.userdata[own]
    return out


def _at_a_stop(model: mujoco.MjModel, data: mujoco.MjData) -> NDArray[np.bool_]:
    # Of each degree of freedom, whether a limit pushes it back.
    out = np.zeros(model.nv, dtype=bool)
    if data.nl:
        limits = data.efc_id[data.efc_type == mujoco.mjtConstraint.mjCNSTR_LIMIT_JOINT]
        out[model.jnt_dofadr[limits]] = True
    return out


def _advance(model: mujoco.MjModel, data: mujoco.MjData, time: float) -> None:
    before = data.time
    mujoco.mj_step(model, data)
    if data.time <= before:  # MuJoCo restarted from its initial state
        raise SimulationError(_broken(model, data, time))


def _weigh(model: mujoco.MjModel, name: str, mass: float) -> None:
    body = model.body(name).id
    more = mass - model.body_mass[body]
    model.body_mass[body] = mass
    while body:
        model.body_subtreemass[body] += more
        body = model.body_parentid[body]
    model.body_subtreemass[0] += more


def _broken(model: mujoco.MjModel, data: mujoco.MjData, time: float) -> str:
    where = ""
    for kind, (_, addresses) in BROKEN.items():
        if data.warning[kind].number:
            joint = int(np.searchsorted(getattr(model, addresses), data.warning[kind].lastinfo, side="right")) - 1
            where = f" at joint '{model.joint(joint).name}'"
    return (
        f"the run went out of bounds{where} near {time:.3g} s: lower the controller's bandwidth, raise the rate or "
        "slow the trajectory down"
    )
