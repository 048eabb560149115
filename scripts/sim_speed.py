"""How fast friction in MuJoCo is, in ratios of one run: ours, the native element and a Python callback, six joints.

The runs take turns, so that a machine that slows down slows all of them.
"""

from __future__ import annotations

import time
from collections.abc import Callable

import mujoco
import mujoco.batch
import numpy as np

from mjfriction.laws.ambient import ambient
from mjfriction.laws.catalog import LAWS
from mjfriction.sim.callback import friction_active
from scripts.sim_accuracy import Case, native_lugre, ours, six_axis_case

SIMULATIONS, STEPS = 64, 400


def integrated(model: mujoco.MjModel, integrator: mujoco.mjtIntegrator) -> mujoco.MjModel:
    """Return the model with an integrator and a step of 1 ms."""
    model.opt.integrator, model.opt.timestep = integrator, 1e-3
    return model


def batch_run(model: mujoco.MjModel, threads: int, steps: int) -> Callable[[], float]:
    """Return a function that runs the batch once and returns its steps per second."""
    batch = mujoco.batch.Batch(model, SIMULATIONS, nthread=threads)
    t = np.arange(steps)[:, None] * 1e-3
    control = np.tile(10.0 * np.sin(10.0 * t + np.arange(6)), (SIMULATIONS, 1, 1))

    def run() -> float:
        batch.reset()  # every turn has the same motion, away from the joints' limits
        begin = time.perf_counter()
        batch.rollout(steps, control=control)
        return SIMULATIONS * steps / (time.perf_counter() - begin)

    return run


def python_run(case: Case, steps: int) -> Callable[[], float]:
    """Return such a function for laws called from a Python control callback, one simulation."""
    model = integrated(case.spec.compile(), mujoco.mjtIntegrator.mjINT_EULER)
    data = mujoco.MjData(model)
    law, room = LAWS["lugre"], ambient(1)[0]
    packed = [law.pack(case.laws[model.joint(i).name]) for i in range(model.nv)]
    states = [np.zeros(1) for _ in packed]

    def rub(model: mujoco.MjModel, data: mujoco.MjData) -> None:
        for i, p in enumerate(packed):
            data.qfrc_passive[i] -= law.advance(float(data.qvel[i]), room, states[i], model.opt.timestep, p, states[i])[
                0
            ]

    def run() -> float:
        mujoco.mj_resetData(model, data)
        mujoco.set_mjcb_control(rub)
        try:
            begin = time.perf_counter()
            mujoco.mj_step(model, data, nstep=steps)
            return steps / (time.perf_counter() - begin)
        finally:
            mujoco.set_mjcb_control(None)

    return run


def turns(runs: dict[str, Callable[[], float]], rounds: int) -> dict[str, np.ndarray]:
    """Return the rates of every run, (rounds,), taken in turns after one round to warm up."""
    found = [{name: run() for name, run in runs.items()} for _ in range(rounds + 1)][1:]
    return {name: np.array([one[name] for one in found]) for name in runs}


def ratio(rates: dict[str, np.ndarray], one: str, other: str) -> float:
    """Return the median over the rounds of one rate over another of the same round."""
    return float(np.median(rates[one] / rates[other]))


def measure(steps: int = STEPS, rounds: int = 25) -> dict[str, np.ndarray]:
    """Return rates in steps a second, (rounds,) each."""
    case = six_axis_case()
    runs = {}
    for name, integrator in (
        ("Euler", mujoco.mjtIntegrator.mjINT_EULER),
        ("implicitfast", mujoco.mjtIntegrator.mjINT_IMPLICITFAST),
    ):
        runs[f"{name}, no friction"] = batch_run(integrated(case.spec.compile(), integrator), 1, steps)
        runs[f"{name}, mjfriction"] = batch_run(integrated(ours(case), integrator), 1, steps)
        runs[f"{name}, native dcmotor lugre"] = batch_run(integrated(native_lugre(case), integrator), 1, steps)
    runs["Euler, mjfriction, two threads"] = batch_run(
        integrated(ours(case), mujoco.mjtIntegrator.mjINT_EULER), 2, steps
    )
    with friction_active():
        rates = turns(runs, rounds)
    plain = batch_run(integrated(case.spec.compile(), mujoco.mjtIntegrator.mjINT_EULER), 1, steps)
    rates |= turns(
        {"Euler, no friction, no callback": plain, "Euler, Python callback": python_run(case, steps)}, rounds
    )
    return rates


if __name__ == "__main__":
    for name, rate in measure().items():
        print(f"{name:<36}{np.median(rate):>10.0f}")
