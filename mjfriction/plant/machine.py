"""A robot file as a machine: everything it states acts in MuJoCo, its drives follow a trajectory, its sensors log."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mjfriction.body.inverse import inertia_at, inverse_dynamics
from mjfriction.errors import RobotError, suggestion
from mjfriction.laws.ambient import ROOM_TEMPERATURE
from mjfriction.laws.friction import Friction
from mjfriction.laws.law import Floats
from mjfriction.plant.sensors import Recorder, record
from mjfriction.plant.trajectory import Trajectory
from mjfriction.robot.friction import raised_levels, stated_levels
from mjfriction.robot.robot import Robot
from mjfriction.robot.rubbing import warmed
from mjfriction.robot.schema import Joint, Spring
from mjfriction.robot.simulation import robot_laws, robot_spec
from mjfriction.sim.closed_loop import Course, Gains, Played, couple_friction, drop_actuators, play, split_transmission

LONGEST_STEP, LONGEST_STEP_GIVING = 1e-3, 2.5e-4  # s; what gives rings faster than a rigid arm
FEEDFORWARD_SPEED = 0.02  # rad/s or m/s over which the feedforward of dry friction turns over
REFRESH = 0.1  # s between updates of friction that varies with temperature, time or pressure


@dataclass(frozen=True)
class Control:
    """Computed torque with joint PD: ``bandwidth`` (Hz) and ``damping`` ratio of every joint on its own inertia;
    ``friction`` feeds the stated Coulomb and viscous friction forward.
    """

    bandwidth: float = 4.0
    damping: float = 0.8
    friction: bool = True


@dataclass(frozen=True)
class Run:
    """What a machine did, on the simulation's own steps: ``time`` (n,), the rest as :class:`Played` says."""

    time: Floats
    played: Played


def simulate(
    robot: Robot,
    trajectory: Trajectory,
    *,
    recorder: Recorder | None = None,
    control: Control | None = None,
    controller_robot: Robot | None = None,
    seed: int = 0,
) -> dict[str, Floats]:
    """Run a robot along a trajectory in closed loop and return the columns of a log.

    ``controller_robot`` is the model that the controller computes with, the robot itself if not given.  The same seed
    gives the same log to the byte.  Raises :class:`RobotError` for a trajectory of other joints and
    :class:`~mjfriction.errors.SimulationError` when the run breaks down.
    """
    recorder, control = recorder or Recorder(), control or Control()
    run = run_machine(robot, trajectory, recorder.rate, control, controller_robot or robot)
    played = run.played
    columns = record(robot, recorder, run.time, played.position, played.velocity, played.torque, seed)
    for name, values in trajectory.ambient.items():
        columns[name] = np.interp(columns["time"], trajectory.time, values)
    return columns


def run_machine(robot: Robot, trajectory: Trajectory, rate: float, control: Control, controller_robot: Robot) -> Run:
    """Run a robot along a trajectory and return what it did at every step of the simulation."""
    for name in trajectory.joints:
        if name not in robot.joints:
            raise RobotError(f"robot '{robot.name}' has no joint '{name}'{suggestion(name, robot.joints)}")
    body = robot.body()
    robot = robot.with_stated_friction(body)
    gives = any(joint.transmission.compliance or joint.transmission.backlash for joint in robot.table.joint)
    longest = LONGEST_STEP_GIVING if gives else LONGEST_STEP
    step = 1.0 / rate / np.ceil(1.0 / rate / longest - 1e-9)
    time = np.arange(trajectory.time[0], trajectory.time[-1] + 0.5 * step, step)
    wanted = _wanted(trajectory, robot, time)
    spec = robot_spec(_without_springs(robot))
    spec.option.timestep = step
    drop_actuators(spec)
    link_inertia = inertia_at(body, wanted[0][0]) - body.armature
    for i, joint in enumerate(robot.table.joint):
        own = joint.transmission
        if own.compliance or own.backlash:
            split_transmission(
                spec, joint.name, compliance=own.compliance, backlash=own.backlash, inertia=float(link_inertia[i])
            )
        for drive in joint.common_drive:
            couple_friction(spec, joint.name, drive.joint, drive.ratio, drive.coulomb, drive.viscous)
    played = play(
        spec,
        robot.joints,
        robot_laws(robot),
        Course(wanted[0], wanted[1], _feedforward(controller_robot, control, *wanted)),
        _gains(robot, control, wanted[0]),
        step,
        passive=_Passive(robot) if _has_passive(robot) else None,
        laws_at=_Varying(robot, trajectory, time, step) if any(map(_varies, robot.table.joint)) else None,
    )
    return Run(time, played)


def _wanted(trajectory: Trajectory, robot: Robot, time: Floats) -> list[Floats]:
    columns = [robot.joints.index(joint) for joint in trajectory.joints]
    out = []
    for values in trajectory.at(time):
        whole = np.zeros((time.size, len(robot.joints)))
        whole[:, columns] = values
        out.append(whole)
    return out


def _feedforward(robot: Robot, control: Control, q: Floats, v: Floats, a: Floats) -> Floats:
    body = robot.body()
    robot = robot.with_stated_friction(body)
    torque = inverse_dynamics(body, q, v, a)
    if control.friction:
        for i, joint in enumerate(robot.table.joint):
            coulomb, viscous = stated_levels(joint)
            torque[:, i] += coulomb * np.tanh(v[:, i] / FEEDFORWARD_SPEED) + viscous * v[:, i]
    return torque


def _gains(robot: Robot, control: Control, q: Floats) -> Gains:
    body = robot.body()
    poses = q[:: max(1, q.shape[0] // 50)]
    inertia = np.max([inertia_at(body, pose) for pose in poses], axis=0)
    angular = 2.0 * np.pi * control.bandwidth
    limit = np.full(inertia.size, np.inf)
    for i, joint in enumerate(robot.table.joint):
        drive = joint.actuator
        if drive.current_limit is not None and drive.torque_constant is not None:
            limit[i] = drive.current_limit * drive.torque_constant * abs(drive.gear_ratio)
    return Gains(inertia * angular**2, 2.0 * control.damping * inertia * angular, limit)


def _without_springs(robot: Robot) -> Robot:
    for joint in robot.table.joint:
        robot = robot.with_joint(joint.model_copy(update={"spring": Spring()}))
    return robot


def _has_passive(robot: Robot) -> bool:
    return any(joint.cogging or joint.spring != Spring() or joint.coupling for joint in robot.table.joint)


class _Passive:
    """Cogging, springs and couplings, which stand against the drives whichever way they turn."""

    def __init__(self, robot: Robot) -> None:
        table = robot.table.joint
        self.waves = [(i, wave) for i, joint in enumerate(table) for wave in joint.cogging]
        self.stiffness = np.array([joint.spring.stiffness for joint in table])
        self.preload = np.array([joint.spring.preload for joint in table])
        shape = (len(table), len(table))
        self.coulomb, self.viscous, self.effort = np.zeros(shape), np.zeros(shape), np.zeros(shape)
        for i, joint in enumerate(table):
            for coupling in joint.coupling:
                k = robot.joints.index(coupling.joint)
                self.coulomb[i, k] += coupling.coulomb
                self.viscous[i, k] += coupling.viscous
                self.effort[i, k] += coupling.effort

    def __call__(self, position: Floats, velocity: Floats, torque: Floats) -> Floats:
        out = self.stiffness * position + self.preload
        for i, wave in self.waves:
            phase = wave.wavenumber * position[i]
            out[i] += wave.cosine * np.cos(phase) + wave.sine * np.sin(phase)
        direction = np.tanh(velocity / (0.05 * FEEDFORWARD_SPEED))
        return np.asarray(out + self.coulomb @ direction + self.viscous @ velocity + self.effort @ torque)


def _varies(joint: Joint) -> bool:
    return (
        joint.warm_up is not None
        or bool(joint.events)
        or any(joint.thermal.model_dump(exclude={"reference_temperature"}).values())
        or any(joint.pressure_friction.model_dump().values())
    )


class _Varying:
    """Friction laws that change with temperature, running time, events and pressure, a few times a second."""

    def __init__(self, robot: Robot, trajectory: Trajectory, time: Floats, step: float) -> None:
        self.robot, self.time = robot, time
        moments = [event.time for joint in robot.table.joint for event in joint.events]
        every = max(1, round(REFRESH / step))
        self.steps = {*range(0, time.size, every), *np.searchsorted(time, moments).tolist()}
        self.ambient = {name: np.interp(time, trajectory.time, values) for name, values in trajectory.ambient.items()}

    def __call__(self, k: int) -> dict[str, list[Friction]] | None:
        if k not in self.steps:
            return None
        robot = self.robot
        for joint in self.robot.table.joint:
            if _varies(joint):
                robot = raised_levels(robot, joint.name, *self._change(joint, k))
        return robot_laws(robot)

    def _change(self, joint: Joint, k: int) -> tuple[float, float]:
        now = self.time[k]
        change = np.zeros(2)
        if joint.warm_up is not None:
            share = float(warmed(np.array([now]), joint.warm_up.time_constant)[0])
            change += share * np.array([joint.warm_up.coulomb, joint.warm_up.viscous])
        for event in joint.events:
            if now >= event.time:
                change += [event.coulomb, event.viscous]
        thermal = joint.thermal
        warmer = self._at(f"temperature.{joint.name}", k, ROOM_TEMPERATURE) - thermal.reference_temperature
        change += warmer * np.array([thermal.coulomb_per_kelvin, thermal.viscous_per_kelvin])
        pressed = joint.pressure_friction
        change[0] += pressed.head * self._at(f"pressure_head.{joint.name}", k, 0.0)
        change[0] += pressed.rod * self._at(f"pressure_rod.{joint.name}", k, 0.0)
        return float(change[0]), float(change[1])

    def _at(self, name: str, k: int, otherwise: float) -> float:
        return float(self.ambient[name][k]) if name in self.ambient else otherwise
