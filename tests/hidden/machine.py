"""A machine with something hidden in it, written apart from the diagnosis.

Rigid-body torques come from MuJoCo's inverse dynamics, friction and drive effects from the formulas below, so that an
agreement with the package (Pinocchio, its own laws and regressors) is evidence.  Nothing here is imported by the
package, and nothing of the package's diagnosis is imported here.
"""

from __future__ import annotations

import sysconfig
import xml.etree.ElementTree as ET
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

import mujoco
import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

Array = np.ndarray
Effect = Callable[["Instant"], Array]

DATA = Path(sysconfig.get_paths()["purelib"]) / "cmeel.prefix/share/example-robot-data/robots"
UR5 = DATA / "ur_description/urdf/ur5_robot.urdf"
UR5_JOINTS = (
    "shoulder_pan_joint",
    "shoulder_lift_joint",
    "elbow_joint",
    "wrist_1_joint",
    "wrist_2_joint",
    "wrist_3_joint",
)
UR5_COULOMB = (9.0, 12.0, 7.0, 2.2, 1.8, 1.4)
UR5_VISCOUS = (11.0, 14.0, 8.0, 2.0, 1.6, 1.2)


@dataclass(frozen=True)
class Instant:
    """One joint's true course, which an effect may read: arrays (n,) of q, v, a, and the torques acting in it;
    ``velocities`` (n, joints) are those of all joints.
    """

    time: Array
    q: Array
    v: Array
    a: Array
    rigid: Array
    friction: Array
    velocities: Array


@dataclass(frozen=True)
class Machine:
    """The real machine: a model file, friction per joint, and per joint the hidden effects added to its torque."""

    model: Path = UR5
    joints: tuple[str, ...] = UR5_JOINTS
    coulomb: tuple[float, ...] = UR5_COULOMB
    viscous: tuple[float, ...] = UR5_VISCOUS
    hidden: Mapping[int, Effect] = field(default_factory=dict)
    sensed: Mapping[int, Effect] = field(default_factory=dict)  # what the position sensor reads beyond the position
    noise: float = 0.2  # of the Coulomb level, on effort
    encoder_bits: int = 18
    position_noise: float = 0.0  # rad
    change: Callable[[mujoco.MjModel], None] | None = None  # of the bodies themselves
    ambient: Mapping[str, Callable[[Array], Array]] = field(default_factory=dict)  # further columns, of time
    velocity: str = "none"  # "none", "clean" or "noisy" measured velocity
    bristle_travel: float = 0.0  # rad over which the Coulomb level builds up after a reversal, and which a rest keeps
    pauses: bool = False  # whether the motion goes from way-point to way-point and rests at each
    reach: tuple[float, ...] = ()  # of each joint's motion, once the usual one
    turning: float = 0.0  # rad/s over which friction turns with its direction, all joints creeping as fast besides


def mujoco_model(path: Path) -> mujoco.MjModel:
    """Read URDF or MJCF into MuJoCo without the meshes, which no dynamics needs when inertias are stated."""
    root = ET.parse(path).getroot()
    if root.tag == "robot":
        for link in root.iter("link"):
            for tag in ("visual", "collision"):
                for element in link.findall(tag):
                    link.remove(element)
        extension = ET.SubElement(root, "mujoco")
        ET.SubElement(extension, "compiler", fusestatic="false", discardvisual="true", balanceinertia="false")
    return mujoco.MjModel.from_xml_string(ET.tostring(root, encoding="unicode"))


def multisine(
    seed: int, joints: int, seconds: float, rate: float, reach: float = 0.7
) -> tuple[Array, Array, Array, Array]:
    """Return time and q, v, a (n, joints) of a smooth motion of five sines a joint, exact in all derivatives."""
    rng = np.random.default_rng(seed)
    time = np.arange(int(seconds * rate)) / rate
    q = np.zeros((time.size, joints))
    v, a = q.copy(), q.copy()
    for j in range(joints):
        frequency = rng.uniform(0.08, 0.55, 5)
        amplitude = rng.uniform(0.3, 1.0, 5) * reach / (1.0 + 3.0 * frequency)
        phase = rng.uniform(0.0, 2.0 * np.pi, 5)
        for f, c, p in zip(2.0 * np.pi * frequency, amplitude, phase, strict=True):
            q[:, j] += c * np.sin(f * time + p)
            v[:, j] += c * f * np.cos(f * time + p)
            a[:, j] -= c * f * f * np.sin(f * time + p)
    return time, q, v, a


def way_points(seed: int, joints: int, seconds: float, rate: float) -> tuple[Array, Array, Array, Array]:
    """Return time and q, v, a (n, joints) of joints that go together from point to point and rest at each."""
    rng = np.random.default_rng(seed)
    time = np.arange(int(seconds * rate)) / rate
    q = np.zeros((time.size, joints))
    v, a = q.copy(), q.copy()
    start, here = 0.0, rng.uniform(-1.2, 1.2, joints)
    while start < seconds:
        there, going, resting = rng.uniform(-1.2, 1.2, joints), rng.uniform(0.7, 3.0), rng.uniform(0.1, 0.8)
        own = (time >= start) & (time < start + going + resting)
        s = np.clip((time[own, None] - start) / going, 0.0, 1.0)
        q[own] = here + (there - here) * s**3 * (10.0 - 15.0 * s + 6.0 * s**2)
        v[own] = (there - here) * 30.0 * s**2 * (1.0 - s) ** 2 / going
        a[own] = (there - here) * 60.0 * s * (1.0 - s) * (1.0 - 2.0 * s) / going**2
        start, here = start + going + resting, there
    return time, q, v, a


def bristle(q: Array, travel: float) -> Array:
    """Return the direction of friction that builds up over a travel, and that a rest keeps, (n,)."""
    z, out = 0.0, np.empty_like(q)
    for k, step in enumerate(np.diff(q, prepend=q[0])):
        z += (np.sign(step) - z) * (1.0 - np.exp(-abs(step) / travel))
        out[k] = z
    return out


def rigid_torque(model: mujoco.MjModel, q: Array, v: Array, a: Array) -> Array:
    """Return MuJoCo's inverse dynamics along a motion, (n, joints)."""
    data = mujoco.MjData(model)
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
    out = np.empty_like(q)
    for i in range(q.shape[0]):
        data.qpos[:], data.qvel[:], data.qacc[:] = q[i], v[i], a[i]
        mujoco.mj_inverse(model, data)
        out[i] = data.qfrc_inverse
    return out


def record(machine: Machine, seed: int, seconds: float = 40.0, rate: float = 250.0) -> dict[str, Array]:
    """Let the machine follow its motion and return what its sensors say, as columns of a log."""
    rng = np.random.default_rng([seed, 1])
    count = len(machine.joints)
    time, q, v, a = (way_points if machine.pauses else multisine)(seed, count, seconds, rate)
    if machine.reach:
        q, v, a = (course * machine.reach for course in (q, v, a))
    if machine.turning:
        creeping = multisine(seed + 1, count, seconds, rate, reach=2.0 * machine.turning)
        q, v, a = (course + creep for course, creep in zip((q, v, a), creeping[1:], strict=True))
    model = mujoco_model(machine.model)
    if machine.change is not None:
        machine.change(model)
    rigid = rigid_torque(model, q, v, a)
    columns = {"time": time, **{name: course(time) for name, course in machine.ambient.items()}}
    step = 2.0 * np.pi / 2**machine.encoder_bits
    for j, joint in enumerate(machine.joints):
        direction = np.tanh(v[:, j] / machine.turning) if machine.turning else np.sign(v[:, j])
        if machine.bristle_travel:
            direction = bristle(q[:, j], machine.bristle_travel)
        friction = machine.coulomb[j] * direction + machine.viscous[j] * v[:, j]
        torque = rigid[:, j] + friction
        course = Instant(time, q[:, j], v[:, j], a[:, j], rigid[:, j], friction, v)
        if j in machine.hidden:
            torque = torque + machine.hidden[j](course)
        read = q[:, j] + (machine.sensed[j](course) if j in machine.sensed else 0.0)
        sensed = read + machine.position_noise * rng.normal(size=time.size)
        columns[f"position.{joint}"] = np.round(sensed / step) * step
        if machine.velocity != "none":
            columns[f"velocity.{joint}"] = v[:, j] + (0.02 if machine.velocity == "noisy" else 0.0) * rng.normal(
                size=time.size
            )
        columns[f"effort.{joint}"] = torque + machine.noise * machine.coulomb[j] * rng.normal(size=time.size)
    return columns


def robot_toml(machine: Machine, *, off: float = 0.0, seed: int = 0) -> str:
    """Return the robot file a user would have stated, its friction levels a fraction ``off`` from the truth."""
    rng = np.random.default_rng([seed, 2])
    lines = ['name = "hidden"', f'model = "{machine.model}"']
    for j, joint in enumerate(machine.joints):
        coulomb, viscous = (
            np.array([machine.coulomb[j], machine.viscous[j]]) * (1.0 + off * rng.normal(size=2))
        ).tolist()
        lines += ["[[joint]]", f'name = "{joint}"']
        lines += [
            f'friction = {{ law = "coulomb_viscous", parameters = {{ coulomb = {coulomb}, viscous = {viscous} }} }}'
        ]
    return "\n".join(lines) + "\n"


def write_case(
    folder: Path, machine: Machine, seed: int, *, off: float = 0.0, seconds: float = 40.0, rate: float = 250.0
) -> tuple[Path, Path]:
    """Write ``log.parquet`` and ``robot.toml`` of a machine and return their paths."""
    folder.mkdir(parents=True, exist_ok=True)
    log, robot = folder / "log.parquet", folder / "robot.toml"
    pq.write_table(pa.table(record(machine, seed, seconds, rate)), log)
    robot.write_text(robot_toml(machine, off=off, seed=seed), encoding="utf-8")
    return log, robot
