"""Cases: a machine with something hidden in it, the robot file its user believes in, and its log."""

from __future__ import annotations

import json
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

import numpy as np
import pyarrow as pa
import pyarrow.parquet

from mjfriction.benchmark.effects.body import link_inertia, payload
from mjfriction.benchmark.effects.catalog import EFFECTS, Draw
from mjfriction.benchmark.effects.effect import OUTSIDE_NAME, Effect, Place
from mjfriction.body.regressor import tip_link
from mjfriction.control.servo import Control
from mjfriction.errors import SimulationError
from mjfriction.laws.law import Floats
from mjfriction.plant.machine import simulate
from mjfriction.plant.motions import KNOTS, excitation, pick_and_place
from mjfriction.plant.sensors import Recorder
from mjfriction.plant.trajectory import Trajectory
from mjfriction.record.log import HEAD_PRESSURE, PUSH, ROD_PRESSURE
from mjfriction.record.motion import estimate_motion
from mjfriction.record.readers.table import log_from_table
from mjfriction.robot.effort import predict_effort
from mjfriction.robot.files import read_robot, write_robot
from mjfriction.robot.friction import raised_levels, stated_levels
from mjfriction.robot.robot import Robot

SEVERITY = {"small": 0.6, "medium": 1.5, "large": 4.0}  # RMS of an effect at its joint, in units of the noise
SCALINGS = 12
CLOSE = 0.05  # relative error of the severity at which the scaling stops
POSES = 24
MOST_HALVINGS = 3  # of the severity, to get a machine that its controller can hold
# Share of the severity that must be reached, otherwise the effect is drawn at another joint: e.g. the zero of a joint
# whose axis is along gravity does not show.
LEAST_REACHED = 0.5
FAINT = 0.5  # severity below which no tool is required to find an effect
OUTLYING = 3.0  # times what stated values are off by, up to which another one that is off does not stand out


@dataclass(frozen=True)
class Setting:
    """How cases are recorded.

    ``rate`` is in Hz.  ``noise`` of the effort is relative to each joint's Coulomb level.  ``encoder`` is in rad per
    count; a sliding joint has as many counts per metre as a revolute one per turn.  ``off`` is how far stated values
    are off (one standard deviation, relative).  ``velocity`` says whether velocity is measured, ``quantity`` what the
    drives report.  ``motion`` is a sum of sines, or moves from pose to pose with rests.
    """

    robot: str = "ur5"
    seconds: float = 70.0
    rate: float = 500.0
    noise: float = 0.2
    encoder: float = 2.0 * np.pi / 2**19
    off: float = 0.0
    velocity: bool = False
    quantity: Literal["effort", "current"] = "effort"
    motion: Literal["excitation", "pick_and_place"] = "excitation"


@dataclass(frozen=True)
class Hidden:
    """What was hidden: its cause, joint and strength, and how far it stands out of the noise (``severity``).

    ``among_others`` says whether it changes a stated value by so little that it does not stand out from those of the
    machine that are off anyway.
    """

    cause: str
    joint: str | None
    strength: float
    severity: float
    among_others: bool = False

    @property
    def faint(self) -> bool:
        """Whether it shows so little that no tool is required to find it."""
        return self.severity < FAINT or self.among_others

    @property
    def outside(self) -> bool:
        """Whether what was hidden matches no cause of the table."""
        return self.cause.startswith(OUTSIDE_NAME)


@dataclass(frozen=True)
class Case:
    """One case: the stated robot, the machine, what is hidden in it, its log and one of another motion."""

    stated: Robot
    machine: Robot
    hidden: tuple[Hidden, ...]
    log: dict[str, Floats]
    other: dict[str, Floats]


def make_case(seed: int, setting: Setting, draws: tuple[Draw, ...], severity: float) -> Case:
    """Make a case with the given effects hidden, each on a joint of its own, scaled to a severity.

    The severity of an effect is the RMS that it adds to the effort of the joint where it shows most, divided by that
    joint's noise, along the motion of the log.  A machine that the stated robot's controller cannot hold, e.g. one with
    a twentieth of the rotor inertia behind backlash, is made again with half the severity.  Raises
    :class:`~mjfriction.errors.SimulationError` where an eighth is too much.
    """
    for _ in range(MOST_HALVINGS):
        try:
            return _made(seed, setting, draws, severity)
        except SimulationError:
            severity *= 0.5
    return _made(seed, setting, draws, severity)


def _made(seed: int, setting: Setting, draws: tuple[Draw, ...], severity: float) -> Case:
    rng = np.random.default_rng([seed, 31])
    machine = _equipped(read_robot(setting.robot), setting)
    joints = machine.joints
    motions = [_motion(machine, setting, int(rng.integers(1 << 30))) for _ in range(2)]
    oil = _chamber_pressures(machine, motions[0])
    hidden: list[Hidden] = []
    ambient: dict[str, Floats] = {}
    pushes: dict[str, Floats] = {}
    places = rng.permutation(len(joints))
    holding = machine.body().link_holding(tip_link(machine.body()))
    for i, draw in enumerate(draws):
        order = [joints[k] for k in np.roll(places, -i)]
        if draw is link_inertia and payload in draws:
            # A payload and the link that holds it are one body.
            order = [joint for joint in order if joint != holding] or order
        for joint in order:
            effect = draw(rng, _place(machine, joint, motions[0]))
            effect = replace(effect, ambient={**effect.ambient, **oil})
            hiding, found = _hide(machine, effect, motions[0], severity)
            if found.severity > LEAST_REACHED * severity:
                break
        machine = hiding
        little = 0.0 < effect.of_stated * found.strength < OUTLYING * setting.off
        hidden.append(replace(found, among_others=little))
        if not oil:
            ambient |= effect.ambient
        if effect.push is not None:
            pushes[f"{PUSH}.{effect.joint}"] = found.strength * effect.push
    stated = _stated(read_robot(setting.robot), setting.off, rng)
    recorder = Recorder(rate=setting.rate, velocity=setting.velocity, quantity=setting.quantity)
    logs = []
    for k, motion in enumerate(motions):
        around = {name: np.interp(motion.time, motions[0].time, values) for name, values in ambient.items()}
        if k == 0:
            around |= pushes
        logs.append(
            simulate(
                machine,
                replace(motion, ambient=around),
                recorder=recorder,
                control=Control(),
                controller_robot=stated,
                seed=seed + 1000003 * k,
            )
        )
    return Case(stated, machine, tuple(hidden), *logs)


def write_case(case: Case, folder: Path) -> None:
    """Write a case: ``log.parquet`` and ``robot.toml`` for the tool; the truth separately, in ``truth/``.

    The truth is ``truth.json``, the machine's robot file and ``other.parquet``.
    """
    (folder / "truth").mkdir(parents=True, exist_ok=True)
    pyarrow.parquet.write_table(pa.table(case.log), folder / "log.parquet", compression="zstd")
    write_robot(case.stated, folder)
    pyarrow.parquet.write_table(pa.table(case.other), folder / "truth" / "other.parquet", compression="zstd")
    write_robot(case.machine, folder / "truth")
    truth = {"hidden": [vars(one) for one in case.hidden]}
    (folder / "truth" / "truth.json").write_text(json.dumps(truth, indent=1) + "\n", encoding="utf-8")


def draw_of(cause: str) -> Draw:
    """Return the function that draws the effect of a cause."""
    return next(draw for draw in EFFECTS if draw.__name__ == cause.split(".")[1] or _ALIAS.get(cause) == draw.__name__)


_ALIAS = {"event.change": "step", "sensor.delay": "delay"}


def _equipped(robot: Robot, setting: Setting) -> Robot:
    body = robot.body()
    robot = robot.with_stated_friction(body)
    for joint, slides in zip(robot.table.joint, body.sliding, strict=True):
        coulomb = stated_levels(joint)[0]
        resolution, noise = (setting.encoder / (2.0 * np.pi), 3e-4) if slides else (setting.encoder, 0.01)
        position = joint.position_sensor.model_copy(update={"resolution": resolution, "velocity_noise": noise})
        effort = joint.effort_sensor.model_copy(update={"noise": setting.noise * coulomb})
        robot = robot.with_joint(joint.model_copy(update={"position_sensor": position, "effort_sensor": effort}))
    return robot


def _motion(robot: Robot, setting: Setting, seed: int) -> Trajectory:
    body = robot.body()
    low = np.where(np.isfinite(body.lower), body.lower, -np.pi)
    high = np.where(np.isfinite(body.upper), body.upper, np.pi)
    rng = np.random.default_rng([seed, 41])
    low, high = np.maximum(low, -2.6), np.minimum(high, 2.6)
    reach = np.minimum(0.35 * (high - low), 1.0)
    centre = rng.uniform(low + 1.1 * reach, high - 1.1 * reach)
    stated = np.where(np.isfinite(body.top_speed), body.top_speed, np.inf)
    top = np.where(np.array(body.sliding), np.minimum(0.5, 0.8 * stated), rng.uniform(0.8, 1.8, reach.size))
    if setting.motion == "excitation":
        return excitation(robot.joints, centre, reach, top, setting.seconds, seed=seed)
    poses = centre + reach * rng.uniform(-1.0, 1.0, (POSES, reach.size))
    made = pick_and_place(robot.joints, poses, top, 4.0 * top)
    resting = np.append(np.all(np.diff(made.position, axis=0) == 0.0, axis=1), True)
    last = int(np.flatnonzero(resting & (made.time <= setting.seconds))[-1])
    return Trajectory(made.joints, made.time[: last + 1], made.position[: last + 1])


def _chamber_pressures(robot: Robot, motion: Trajectory) -> dict[str, Floats]:
    # Chamber pressures of a cylinder along the motion, before anything is hidden; empty without a cylinder.
    if all(joint.hydraulics is None for joint in robot.table.joint):
        return {}
    log = simulate(robot, motion, recorder=Recorder(rate=KNOTS))
    names = [name for name in log if name.startswith((HEAD_PRESSURE, ROD_PRESSURE))]
    return {name: np.interp(motion.time, log["time"], log[name]) for name in names}


def _place(robot: Robot, joint: str, motion: Trajectory) -> Place:
    course = motion.position[:, motion.joints.index(joint)]
    speed = float(np.quantile(np.abs(np.gradient(course, motion.time)), 0.9))
    return Place(robot, joint, float(np.mean(course)), float(np.ptp(course)), speed, motion.time, course)


def _hide(machine: Robot, effect: Effect, motion: Trajectory, severity: float) -> tuple[Robot, Hidden]:
    # Find the strength from the efforts predicted along the wanted motion, by proportional scaling: most effects are
    # nearly linear.
    table = {"time": motion.time, **{f"position.{j}": motion.position[:, i] for i, j in enumerate(motion.joints)}}
    table |= {f"effort.{j}": np.zeros(motion.time.size) for j in motion.joints} | dict(effect.ambient)
    course = estimate_motion(log_from_table(pa.table(table), "motion"), machine.joints, 20.0)
    noise = np.array([joint.effort_sensor.noise for joint in machine.table.joint])
    before = predict_effort(machine, machine.body(), course).reported
    moving = np.abs(course.velocity) > 0.05 * np.max(np.abs(course.velocity), axis=0)

    push = None if effect.push is None else np.interp(course.time, motion.time, effect.push)

    def standing_out(strength: float) -> float:
        changed = effect.change(machine, strength)
        after = predict_effort(changed, changed.body(), course).reported
        if push is not None:
            after[:, machine.joints.index(str(effect.joint))] -= strength * push
        power = np.sum(np.where(moving, np.square(after - before), 0.0), axis=0) / np.sum(moving, axis=0)
        return float(np.max(np.sqrt(power) / noise))

    strength = effect.begin
    for _ in range(SCALINGS):
        reached = standing_out(strength)
        if abs(reached / severity - 1.0) < CLOSE or (strength >= effect.most and reached < severity):
            break
        strength = float(
            np.clip(strength * severity / max(reached, 1e-9), 0.1 * strength, min(5.0 * strength, effect.most))
        )
    return effect.change(machine, strength), Hidden(effect.cause, effect.joint, strength, standing_out(strength))


def _stated(robot: Robot, off: float, rng: np.random.Generator) -> Robot:
    # Friction levels and link masses are a few percent off everywhere, as in every stated model.
    robot = robot.with_stated_friction(robot.body())
    if off == 0.0:
        return robot
    for joint in robot.table.joint:
        coulomb, viscous = stated_levels(joint)
        change = np.clip(off * rng.standard_normal(2), -2.5 * off, 2.5 * off)
        robot = raised_levels(robot, joint.name, coulomb * float(change[0]), viscous * float(change[1]))
    scale = {name: float(1.0 + np.clip(0.5 * off * rng.standard_normal(), -off, off)) for name in robot.joints}
    return Robot(robot.table.model_copy(update={"link_scale": scale}), robot.folder)
