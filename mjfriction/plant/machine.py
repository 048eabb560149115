"""A robot file as a machine: everything it states acts in MuJoCo, its drives follow a trajectory, its sensors log."""

from __future__ import annotations

import warnings
from dataclasses import dataclass

import numpy as np

from mjfriction.body.inverse import inertia_along
from mjfriction.body.model import Body
from mjfriction.control.course import Course
from mjfriction.control.servo import Control, ServoDrives
from mjfriction.errors import RobotError, suggestion
from mjfriction.laws.law import Floats
from mjfriction.plant.cylinder import Cylinder
from mjfriction.plant.oil import OilDrives
from mjfriction.plant.passive import Passive, has_passive
from mjfriction.plant.sensors import Recorder, record
from mjfriction.plant.taken_up import HeldMasses
from mjfriction.plant.trajectory import Trajectory
from mjfriction.plant.varying import Surrounding, Varying, varies, with_pressed_seals, with_room_to_vary
from mjfriction.progress import Tell, silently
from mjfriction.record.log import PUSH, VOLTAGE
from mjfriction.robot.robot import Robot
from mjfriction.robot.schema import Spring
from mjfriction.robot.simulation import robot_laws, robot_spec
from mjfriction.sim.closed_loop import Drive, Played, play
from mjfriction.sim.spec import Spec, drop_actuators
from mjfriction.sim.transmission import DeadZone, couple_drive, split_transmission

FOLLOWED = 0.5  # a joint that travels less than this fraction of the wanted travel has not followed
POSES = 500  # along a motion, at which the links' inertia is looked up
# s; transmissions that give oscillate faster than a rigid arm.
LONGEST_STEP, LONGEST_STEP_GIVING, LONGEST_STEP_OIL = 1e-3, 2.5e-4, 1e-4


@dataclass(frozen=True)
class Run:
    """What a machine did, on the simulation's own steps ``time`` (n,).

    ``played`` is as :class:`Played` says, ``cylinders`` are by the joint that they move, and ``notes`` are sentences
    that a user should read.  ``wanted`` is the wanted position of the joints and ``estimates`` the friction that their
    controller used, (n, joints) each.
    """

    time: Floats
    wanted: Floats
    played: Played
    cylinders: dict[str, Cylinder]
    estimates: Floats
    notes: tuple[str, ...]


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
    :class:`~mjfriction.errors.SimulationError` when the run breaks down; warns of a cylinder that cavitates, of joints
    at their stops, and of shapes that touch.
    """
    recorder = recorder or Recorder()
    run = run_machine(robot, trajectory, recorder.rate, control, controller_robot)
    for note in run.notes:
        warnings.warn(note, stacklevel=2)
    return log_columns(robot, trajectory, recorder, run, seed)


def log_columns(robot: Robot, trajectory: Trajectory, recorder: Recorder, run: Run, seed: int) -> dict[str, Floats]:
    """Return the columns of the log that a robot's sensors record of a run."""
    columns = record(robot, recorder, run.time, run.played, run.cylinders, seed)
    for name, values in trajectory.ambient.items():
        if name.startswith(f"{PUSH}."):
            continue  # no sensor measures an external push
        columns.setdefault(name, np.interp(columns["time"], trajectory.time, values))
    return columns


def run_machine(
    robot: Robot,
    trajectory: Trajectory,
    rate: float,
    control: Control | None = None,
    controller_robot: Robot | None = None,
    *,
    whole: bool = False,
    tell: Tell = silently,
) -> Run:
    """Run a robot along a trajectory, at least ``rate`` steps a second, and return what it did at every step.

    With ``whole`` the states of the friction laws are recorded, for plots; ``tell`` receives progress reports.
    """
    _check(robot, trajectory)
    control, body = control or Control(), robot.body()
    model = _controller(robot, controller_robot or robot)
    robot = with_room_to_vary(with_pressed_seals(robot.with_stated_friction(body)))
    step = 1.0 / rate / np.ceil(1.0 / rate / _longest_step(robot) - 1e-9)
    time = np.arange(trajectory.time[0], trajectory.time[-1] + 0.5 * step, step)
    course = _course(trajectory, robot, time)
    surrounding = Surrounding(robot, trajectory, time)
    servo = ServoDrives(robot, model, control, course, step)
    drive: Drive = servo
    cylinders: dict[str, Cylinder] = {}
    if any(joint.hydraulics for joint in robot.table.joint):
        oil = OilDrives(robot, model, servo, control, trajectory, time, surrounding)
        drive, cylinders = oil, oil.cylinders
    spec, dead_zones = _spec(robot, step, _usual_inertia(body, course.position))
    played = play(
        spec,
        robot.joints,
        robot_laws(robot),
        np.array([course.position[0], course.velocity[0]]),
        drive,
        time.size,
        step,
        dead_zones=dead_zones,
        passive=Passive(robot) if has_passive(robot) else None,
        around=surrounding,
        laws_at=Varying(robot, surrounding, time, step) if any(map(varies, robot.table.joint)) else None,
        masses_at=HeldMasses(robot, time) if robot.table.taken_up else None,
        whole=whole,
        tell=tell,
    )
    notes = [note for name, cylinder in cylinders.items() for note in cylinder.notes(time, name)]
    if control.observer is not None or control.friction == "law":
        idle = "is moved by oil, not by a drive: friction is neither fed forward nor observed there"
        notes += [f"joint '{name}' {idle}" for name in cylinders]
    for joint, samples in zip(robot.joints, np.count_nonzero(played.stopped, axis=0).tolist(), strict=True):
        if samples:
            notes.append(
                f"joint '{joint}' is at a stop of its range for {samples * step:.3g} s; what that takes is in the log, "
                "and in no prediction of efforts"
            )
    if touching := float(np.count_nonzero(played.touching)) * step:
        notes.append(
            f"shapes of the model touch each other for {touching:.3g} s; what that takes is in the log, and in no "
            "prediction of efforts"
        )
    return Run(time, course.position, played, cylinders, servo.estimates, tuple(notes))


def not_followed(robot: Robot, run: Run) -> list[str]:
    """Return a sentence for each joint that travelled less than half as far as it should."""
    out, sliding = [], robot.body().sliding
    for i, name in enumerate(robot.joints):
        asked, went = (float(np.ptp(course[:, i])) for course in (run.wanted, run.played.position))
        if went < FOLLOWED * asked:
            unit = "m" if sliding[i] else "rad"
            out.append(f"joint '{name}' did not follow: it was to travel {asked:.3g} {unit} and went {went:.3g} {unit}")
    return out


def _check(robot: Robot, trajectory: Trajectory) -> None:
    for name in trajectory.joints:
        robot.joint(name)
    for name in trajectory.ambient:
        quantity, _, place = name.partition(".")
        if quantity == PUSH and place not in robot.joints:
            raise RobotError(f"robot '{robot.name}' has no joint '{place}' to push{suggestion(place, robot.joints)}")
        if quantity == VOLTAGE and (place not in robot.joints or robot.joint(place).hydraulics is None):
            raise RobotError(f"robot '{robot.name}': the trajectory has '{name}', but no cylinder moves such a joint")


def _spec(robot: Robot, step: float, link_inertia: Floats) -> tuple[Spec, dict[str, DeadZone]]:
    # The model with its compliance, backlash and shared drives.  Springs are left out, because they act as passive
    # torques on the drives.
    spec = robot_spec(_without_springs(robot), with_taken_up=True)
    spec.option.timestep = step
    drop_actuators(spec)
    dead_zones: dict[str, DeadZone] = {}
    for i, joint in enumerate(robot.table.joint):
        own = joint.transmission
        if own.compliance or own.backlash:
            zone = split_transmission(
                spec,
                joint.name,
                compliance=own.compliance,
                backlash=own.backlash,
                inertia=float(link_inertia[i]),
                damping_ratio=own.damping_ratio,
                hardening=own.hardening,
            )
            if zone is not None:
                dead_zones[joint.name] = zone
        for shared in joint.common_drive:
            couple_drive(
                spec,
                joint.name,
                shared.joint,
                shared.ratio,
                coulomb=shared.coulomb,
                viscous=shared.viscous,
                inertia=shared.inertia,
            )
    return spec, dead_zones


def _usual_inertia(body: Body, position: Floats) -> Floats:
    # The links' usual inertia along a motion (n, joints), to which damping ratios are relative, (joints,).
    return np.asarray(np.median(inertia_along(body, position[:: max(1, len(position) // POSES)]), axis=0))


def _controller(robot: Robot, model: Robot) -> Robot:
    # The controller's model must have the machine's joints; it is returned with them in the machine's order.
    if set(model.joints) != set(robot.joints):
        raise RobotError(
            f"the controller's robot '{model.name}' has joints {', '.join(model.joints)}, the machine "
            f"'{robot.name}' {', '.join(robot.joints)}; give a model of the same machine"
        )
    joints = tuple(model.joint(name) for name in robot.joints)
    return Robot(model.table.model_copy(update={"joint": joints}), model.folder)


def _longest_step(robot: Robot) -> float:
    joints = robot.table.joint
    if any(joint.hydraulics for joint in joints):
        return LONGEST_STEP_OIL
    gives = any(joint.transmission.gives for joint in joints)
    return LONGEST_STEP_GIVING if gives else LONGEST_STEP


def _course(trajectory: Trajectory, robot: Robot, time: Floats) -> Course:
    columns = [robot.joints.index(joint) for joint in trajectory.joints]
    out = []
    for values in trajectory.at(time):
        whole = np.zeros((time.size, len(robot.joints)))
        whole[:, columns] = values
        out.append(whole)
    return Course(*out)


def _without_springs(robot: Robot) -> Robot:
    for joint in robot.table.joint:
        robot = robot.with_joint(joint.model_copy(update={"spring": Spring()}))
    return robot
