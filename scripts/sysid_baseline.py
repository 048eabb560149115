"""MuJoCo's own identification toolbox as a tool to compare mjfriction with: it fits parameters and names no causes.

python -m scripts.sysid_baseline diagnose LOG --robot R --out DIR
python -m scripts.sysid_baseline predict LOG --robot DIR/robot.toml --out P.parquet

Damping, dry friction and rotor inertia of every joint and a scale of every link's mass, fitted as one would with
`mujoco.sysid`: the log is cut into stretches, each is simulated from its measured state under the measured efforts, and
its states are compared with the measured ones.  The fit is written as a robot file.  Needs the packages of
requirements-bench.lock.
"""

from __future__ import annotations

import contextlib
import json
import os
import sys
from functools import partial
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pyarrow as pa
import pyarrow.parquet
from mujoco import sysid

from mjfriction.identify.gap import Gap
from mjfriction.identify.measure import measure_gap
from mjfriction.record.readers import read_log
from mjfriction.robot.files import read_robot, write_robot
from mjfriction.robot.friction import stated_levels
from mjfriction.robot.friction_tables import FrictionTerm
from mjfriction.robot.predict import predict_log
from mjfriction.robot.robot import Robot
from mjfriction.robot.simulation import robot_spec
from scripts.verbs import run_verbs

LONGEST_STEP, STRETCH = 0.01, 0.5  # s; finer steps and other stretches gave the same errors within 1 %
ROUNDS = 8
KINDS = ("damping", "frictionloss", "armature", "mass")
# Bounds of the fit, as multiples of the stated values.
WIDE = {"mass": (0.7, 1.3), "armature": (0.2, 3.0), "damping": (0.0, 5.0), "frictionloss": (0.0, 5.0)}
LEAST = {"armature": 1e-3, "damping": 1e-3, "frictionloss": 1e-3}  # added to the upper bound, for values stated as 0


def prepared(robot: Robot, step: float) -> mujoco.MjSpec:
    """Return the model with MuJoCo's own friction at the stated levels, and motors."""
    spec = robot_spec(robot)
    for actuator in list(spec.actuators):
        spec.delete(actuator)
    for table in robot.table.joint:
        joint = spec.joint(table.name)
        joint.frictionloss, joint.damping[0] = stated_levels(table)
        joint.actfrclimited = mujoco.mjtLimited.mjLIMITED_FALSE
        joint.solref_friction = [2.0 * step, 1.0]  # as stiff as is stable
        joint.solimp_friction = [0.99, 0.99, 0.001, 0.5, 2.0]
        motor = spec.add_actuator(name=table.name, target=table.name, trntype=mujoco.mjtTrn.mjTRN_JOINT)
        motor.set_to_motor()
        motor.biastype = mujoco.mjtBias.mjBIAS_AFFINE  # its constant can represent the effort's offset
    spec.option.timestep = step
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    spec.option.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONTACT | mujoco.mjtDisableBit.mjDSBL_LIMIT
    return spec


def parameters(spec: mujoco.MjSpec, joints: tuple[str, ...], kinds: tuple[str, ...] = KINDS) -> sysid.ParameterDict:
    """Return the parameters to fit: three per joint and one per link, or only those of the given ``kinds``."""
    out, model = sysid.ParameterDict(), spec.compile()
    for name in joints:
        joint = spec.joint(name)
        stated = {
            "damping": (joint.damping[0], partial(_set_damping, name)),
            "frictionloss": (joint.frictionloss, partial(_set, name, "frictionloss")),
            "armature": (joint.armature, partial(_set, name, "armature")),
            "mass": (1.0, partial(_set_mass, _inertial(model, joint.parent.name))),
            "zero": (0.0, partial(_set_zero, name)),
        }
        for kind in kinds:
            value, modifier = stated[kind]
            if kind == "zero":
                low, high = -joint.frictionloss, joint.frictionloss
            else:
                low, high = (share * value for share in WIDE[kind])
                high += LEAST.get(kind, 0.0)
            out.add(sysid.Parameter(f"{name}.{kind}", value, low, high, modifier=modifier))
    return out


def _set_damping(name: str, spec: mujoco.MjSpec, parameter: sysid.Parameter) -> None:
    spec.joint(name).damping[0] = parameter.value[0]


def _set_zero(name: str, spec: mujoco.MjSpec, parameter: sysid.Parameter) -> None:
    spec.actuator(name).biasprm[0] = -parameter.value[0]


def _set(name: str, key: str, spec: mujoco.MjSpec, parameter: sysid.Parameter) -> None:
    setattr(spec.joint(name), key, parameter.value[0])


def _inertial(model: mujoco.MjModel, name: str) -> dict[str, Any]:
    body = model.body(name)
    return {
        "name": name,
        "mass": float(body.mass[0]),
        "inertia": body.inertia.copy(),
        "ipos": body.ipos.copy(),
        "iquat": body.iquat.copy(),
    }


def _set_mass(stated: dict[str, Any], spec: mujoco.MjSpec, parameter: sysid.Parameter) -> None:
    # The toolbox's own modifier of masses assigns an array to a scalar, which MuJoCo 4.0 refuses.
    link, share = spec.body(stated["name"]), parameter.value[0]
    link.explicitinertial, link.fullinertia = True, np.full((6, 1), np.nan)
    link.mass, link.inertia = stated["mass"] * share, stated["inertia"] * share
    link.ipos, link.iquat = stated["ipos"], stated["iquat"]


def stretches(gap: Gap, model: mujoco.MjModel, every: int, seconds: float = STRETCH) -> list[sysid.SystemTrajectory]:
    """Return the log in stretches of ``seconds``, each beginning at its measured state.

    A step of the model covers ``every`` samples of the log; efforts are means over the model's steps.
    """
    motion, step = gap.motion, model.opt.timestep
    longest = min(own.stop - 1 - own.start for own in motion.pieces) / motion.rate - 1.0
    steps = round(min(seconds, longest) / step)
    effort = np.nan_to_num(motion.torque * gap.per_reported)
    summed = np.vstack([np.zeros(effort.shape[1]), np.cumsum(0.5 * (effort[1:] + effort[:-1]), axis=0)])
    places = [model.joint(name) for name in motion.joints]
    q_order = np.argsort([joint.qposadr[0] for joint in places])
    names = [f"{motion.joints[i]}_{what}" for what in ("qpos", "qvel") for i in q_order]
    drives = [model.actuator(name).id for name in motion.joints]
    times = step * np.arange(steps + 1)
    out = []
    for own in motion.pieces:
        for start in range(own.start + round(0.5 * motion.rate), own.stop - 1 - steps * every, steps * every):
            at = start + every * np.arange(steps + 1)
            control = np.zeros((steps + 1, model.nu))  # the toolbox never applies the last row
            control[:-1, drives] = (summed[at[1:]] - summed[at[:-1]]) / every
            course = np.hstack([motion.position[at][:, q_order], motion.velocity[at][:, q_order]])
            out.append(
                sysid.SystemTrajectory(
                    model=model,
                    control=sysid.TimeSeries.from_control_names(times, control, model),
                    # States, not sensors: sensors of a rollout lag one step behind their time stamps.
                    sensordata=sysid.TimeSeries.from_names(times, course, model, names=names),
                    initial_state=sysid.create_initial_state(
                        model, motion.position[start, q_order], motion.velocity[start, q_order]
                    ),
                    state=None,
                )
            )
    return out


def residual_of(spec: mujoco.MjSpec, parts: list[sysid.SystemTrajectory]):
    """Return the residual over all stretches, each state in units of its RMS error as stated, and its weighting."""
    width = parts[0].sensordata.data.shape[1]
    weight = np.ones(width)

    def differ(params, predicted, measured, model, return_all, state=None, **_):
        del params, predicted, model, return_all
        seen = sysid.TimeSeries(measured.times[1:], measured.data[1:], measured.signal_mapping)
        told = sysid.TimeSeries(measured.times[1:], state[:, 1 : 1 + width], measured.signal_mapping)
        return (seen.data - told.data) * weight, told, seen

    def residual(x, params, **_):
        found, told, seen = sysid.model_residual(
            x, params, lambda p: sysid.apply_param_modifiers(p, spec), parts,
            modify_residual=differ, n_threads=1, resample_true=False,
        )  # fmt: skip
        return [found.T.reshape(x.shape[1], -1).T if x.ndim > 1 else found], told, seen

    def weigh(params) -> None:
        rows = residual(params.as_vector(), params)[0][0].reshape(-1, width) / weight
        weight[:] = 1.0 / np.maximum(np.sqrt(np.mean(np.square(rows), axis=0)), 1e-12)

    return residual, weigh


def fit(
    gap: Gap, *, seconds: float = STRETCH, longest_step: float = LONGEST_STEP, kinds: tuple[str, ...] = KINDS
) -> dict[str, float]:
    """Return the fitted parameters by name."""
    every = max(1, int(longest_step * gap.motion.rate + 1e-9))
    spec = prepared(gap.robot, every / gap.motion.rate)
    params = parameters(spec, gap.robot.joints, kinds)
    residual, weigh = residual_of(spec, stretches(gap, spec.compile(), every, seconds))
    weigh(params)
    with open(os.devnull, "w", encoding="utf-8") as nowhere, contextlib.redirect_stdout(nowhere):
        params, _ = sysid.optimize(
            params, residual, optimizer="mujoco", verbose=False, max_iters=ROUNDS, x_scale="jac", xtol=1e-4
        )
    return {parameter.name: float(parameter.value[0]) for parameter in params.values()}


def fitted_robot(robot: Robot, found: dict[str, float]) -> Robot:
    """Return a robot with the fitted values in place of the stated ones."""
    scale = {
        name: found[f"{name}.mass"] * robot.table.link_scale.get(name, 1.0)
        for name in robot.joints
        if f"{name}.mass" in found
    }
    fitted = Robot(robot.table.model_copy(update={"link_scale": {**robot.table.link_scale, **scale}}), robot.folder)
    for name in robot.joints:
        joint = fitted.joint(name)
        levels = {"coulomb": found[f"{name}.frictionloss"], "viscous": found[f"{name}.damping"]}
        changes: dict[str, Any] = {"friction": (FrictionTerm(law="coulomb_viscous", parameters=levels),)}
        if f"{name}.armature" in found:
            inertia = found[f"{name}.armature"] / joint.actuator.gear_ratio**2
            changes["actuator"] = joint.actuator.model_copy(update={"rotor_inertia": inertia})
        if f"{name}.zero" in found:
            changes["effort_sensor"] = joint.effort_sensor.model_copy(update={"offset": found[f"{name}.zero"]})
        fitted = fitted.with_joint(joint.model_copy(update=changes))
    return fitted


def diagnose(log: Path, stated: Path, out: Path) -> None:
    gap = measure_gap(read_log(log), read_robot(stated))
    found = fit(gap)
    out.mkdir(parents=True, exist_ok=True)
    write_robot(fitted_robot(gap.robot, found), out)
    (out / "report.json").write_text(json.dumps({"verdict": "fitted", "findings": [], "parameters": found}), "utf-8")


def predict(log: Path, stated: Path, out: Path) -> None:
    pyarrow.parquet.write_table(pa.table(predict_log(read_log(log), read_robot(stated))), out)


if __name__ == "__main__":
    if not hasattr(sysid, "optimize"):  # the toolbox hides that packages are missing
        sys.exit("mujoco.sysid is not complete: python -m pip install --require-hashes -r requirements-bench.lock")
    run_verbs(__doc__, diagnose, predict)
