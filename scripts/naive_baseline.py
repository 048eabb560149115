"""A naive tool to compare mjfriction with: all terms at once by least squares, causes by t-test.

It has the verbs that the benchmark requires of a tool:

python -m scripts.naive_baseline diagnose LOG --robot R --out DIR
python -m scripts.naive_baseline predict LOG --robot DIR/robot.toml --out P.parquet

Log, rigid bodies and the filter that both sides pass are mjfriction's own, so that only the choice of causes differs:
all terms of a joint are fitted together, and every significant one is a finding.
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet
from scipy.stats import t as student

from mjfriction.body.regressor import tip_link
from mjfriction.identify.gap import Gap
from mjfriction.identify.measure import measure_gap
from mjfriction.laws.law import Floats
from mjfriction.record.motion import back_to_log
from mjfriction.record.readers import read_log
from mjfriction.robot.body_tables import Payload
from mjfriction.robot.effort import predict_effort
from mjfriction.robot.files import read_robot, write_robot
from mjfriction.robot.robot import Robot
from scripts.verbs import run_verbs

LEVEL = 1e-3  # two-sided significance level of the t-test
WAVES = 10  # largest number of periods over the stroke
COEFFICIENTS = "coefficients.json"
WHOLE_ARM = ("body.payload", "body.link_inertia", "body.gravity_direction")

Terms = dict[str, Floats]  # "cause/which": (n,)


def frame_of(gap: Gap, joint: int) -> dict[str, float]:
    """Return the scales of a joint's terms: fixed on the fitted log, and reused when another log is predicted."""
    motion = gap.motion
    q = motion.position[:, joint]
    temperature = motion.columns.get(f"temperature.{motion.joints[joint]}", np.zeros(1))
    return {
        "fast": float(np.quantile(np.abs(motion.velocity[:, joint]), 0.9)),
        "low": float(np.min(q)),
        "stroke": max(float(np.ptp(q)), 1e-9),
        "mean": float(np.mean(q)),
        "half": float(0.5 * (motion.time[-1] - motion.time[0])),
        "temperature": float(np.mean(temperature)),
    }


def terms(gap: Gap, joint: int, wide: dict[str, Floats], frame: dict[str, float]) -> Terms:
    """Return every term of a joint, (n,) each, named by the cause that it stands for."""
    motion, effort = gap.motion, gap.effort
    q, v, a = (course[:, joint] for course in (motion.position, motion.velocity, motion.acceleration))
    sign = gap.forward(joint)
    near_rest = np.exp(-((v / (0.15 * frame["fast"])) ** 2))
    running = motion.time - motion.time[0]
    rate = 1.0 / motion.rate
    rigid = effort.rigid[:, joint]
    out = {
        "drive.offset": np.ones_like(v),
        "friction.coulomb_viscous/coulomb": sign,
        "friction.coulomb_viscous/viscous": v,
        "friction.asymmetry": np.abs(v),
        "friction.viscous_nonlinear": v * np.abs(v),
        "friction.stribeck": sign * near_rest,
        "friction.presliding": np.gradient(sign, rate) * near_rest,
        "friction.load": sign * np.abs(rigid),
        "friction.temperature": sign * running,
        "event.change": sign * (running > frame["half"]),
        "drive.torque_constant": effort.total[:, joint],
        "drive.rotor_inertia": a,
        "drive.backlash": np.gradient(rigid, rate) * np.sign(rigid),
        "sensor.delay": np.gradient(effort.total[:, joint], rate),
        "body.spring": q - frame["mean"],
    }
    warmth = motion.columns.get(f"temperature.{motion.joints[joint]}")
    if warmth is not None:
        out["friction.temperature/measured"] = sign * (warmth - frame["temperature"])
    for side in ("head", "rod"):
        pressure = motion.columns.get(f"pressure_{side}.{motion.joints[joint]}")
        if pressure is not None:
            out[f"hydraulic.pressure/{side}"] = sign * pressure / 1e6
    for k in range(1, WAVES + 1):
        angle = 2.0 * np.pi * k * (q - frame["low"]) / frame["stroke"]
        for which, wave in (("cosine", np.cos(angle)), ("sine", np.sin(angle))):
            out[f"drive.cogging/{k}{which}"] = wave
            out[f"friction.position/{k}{which}"] = sign * wave
    for other in range(motion.velocity.shape[1]):
        if other != joint:
            out[f"drive.coupling/{motion.joints[other]}"] = motion.velocity[:, other]
    return out | {name: columns[:, joint] for name, columns in wide.items()}


def wide_terms(gap: Gap) -> dict[str, Floats]:
    """Return the terms that act on all joints, (n, joints) each: the effort that a small change of each cause adds."""
    robot, now = gap.robot, gap.effort.rigid
    tip = tip_link(robot.body())
    gravity = np.array(robot.body().gravity)

    def with_table(**changes: object) -> Floats:
        changed = Robot(robot.table.model_copy(update=changes), robot.folder)
        return predict_effort(changed, changed.body(), gap.motion).rigid - now

    out = {"body.payload": with_table(payload=Payload(mass=1.0, com=(0.0, 0.0, 0.0), parent=tip))}
    across = np.linalg.norm(gravity) * np.eye(3)[[i for i in range(3) if abs(gravity[i]) < 1e-9]]
    for i, way in enumerate(across):
        out[f"body.gravity_direction/{i}"] = with_table(gravity=tuple((gravity + 0.1 * way).tolist()))
    scale = dict(robot.table.link_scale)
    for name in robot.joints:
        out[f"body.link_inertia/{name}"] = with_table(link_scale={**scale, name: 1.1 * scale.get(name, 1.0)})
    for i, name in enumerate(robot.joints):
        sensor = robot.table.joint[i].position_sensor
        moved = sensor.model_copy(update={"offset": sensor.offset + 0.01})
        changed = robot.with_joint(robot.joint(name).model_copy(update={"position_sensor": moved}))
        shifted = predict_effort(changed, changed.body(), gap.motion).rigid - now
        out[f"sensor.encoder_offset/{name}"] = shifted
    return {name: columns for name, columns in out.items() if np.any(np.abs(columns) > 1e-9)}


def fitted(rows: Floats, target: Floats) -> tuple[Floats, Floats]:
    """Return coefficients and their two-sided p-values, as in a textbook."""
    size = np.maximum(np.sqrt(np.mean(np.square(rows), axis=0)), 1e-12)
    inverse = np.linalg.pinv(rows / size, rcond=1e-8)
    found = inverse @ target
    left = target - rows / size @ found
    freedoms = max(1, target.size - rows.shape[1])
    error = np.sqrt(np.sum(np.square(inverse), axis=1) * np.sum(np.square(left)) / freedoms)
    return found / size, 2.0 * student.sf(np.abs(found) / np.maximum(error, 1e-300), freedoms)


def said_of(name: str, joint: str) -> tuple[str, str | None]:
    """Return the cause and the joint that a term of a joint's balance stands for."""
    cause, _, which = name.partition("/")
    if cause in WHOLE_ARM:
        return cause, None
    return cause, which if cause == "sensor.encoder_offset" else joint


def diagnose(log: Path, stated: Path, out: Path) -> None:
    gap = measure_gap(read_log(log), read_robot(stated))
    wide, findings, kept = wide_terms(gap), {}, {}
    for joint in gap.examined:
        name = gap.robot.joints[joint]
        frame = frame_of(gap, joint)
        columns = terms(gap, joint, wide, frame)
        rows = gap.chain.rows(np.column_stack(list(columns.values())))
        clear = gap.clear[:, joint]
        _, chance = fitted(rows[clear], gap.residual[clear, joint])
        named = [term for term, p in zip(columns, chance, strict=True) if p < LEVEL]
        if named:
            picked = [list(columns).index(term) for term in named]
            values, _ = fitted(rows[clear][:, picked], gap.residual[clear, joint])
            kept[name] = {"frame": frame, "values": dict(zip(named, values.tolist(), strict=True))}
        for term in named:
            findings[said_of(term, name)] = 1.0 - LEVEL
    out.mkdir(parents=True, exist_ok=True)
    write_robot(read_robot(stated), out)
    (out / COEFFICIENTS).write_text(json.dumps(kept), encoding="utf-8")
    listed = [
        {"cause": cause, "joint": joint, "confidence": sure, "alternatives": []}
        for (cause, joint), sure in findings.items()
    ]
    report = {"verdict": "explained" if listed else "consistent", "findings": listed}
    (out / "report.json").write_text(json.dumps(report), encoding="utf-8")


def predict(log: Path, stated: Path, out: Path) -> None:
    recorded = read_log(log)
    gap = measure_gap(recorded, read_robot(stated))
    beside = stated.parent / COEFFICIENTS
    kept = json.loads(beside.read_text()) if beside.is_file() else {}
    wide = wide_terms(gap)
    columns = {"time": recorded.time if recorded.recorded is None else recorded.recorded}
    for joint in gap.examined:
        name = gap.robot.joints[joint]
        told = gap.effort.reported[:, joint].copy()
        if name in kept:
            own = terms(gap, joint, wide, kept[name]["frame"])
            told += sum(value * own[term] for term, value in kept[name]["values"].items() if term in own)
        quantity = gap.motion.quantity[joint]
        columns[f"{quantity}.{name}"] = recorded.as_recorded(
            back_to_log(gap.motion, recorded, told / gap.per_reported[joint])
        )
    pyarrow.parquet.write_table(pa.table(columns), out)


if __name__ == "__main__":
    run_verbs(__doc__, diagnose, predict)
