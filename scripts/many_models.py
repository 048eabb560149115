"""From a log to hundreds of plausible models: laws drawn from their intervals, run in one MuJoCo Batch.

A policy can be tried on all of them at once.  Here the elbow of a UR5, whose law is identified on the bundled log,
coasts from a given speed.  The script prints how far it goes as stated and as identified, and the bounds between which
nine in ten plausible arms stop.  Parameters are drawn independently: where the log correlates two of them, the bounds
are wider than the log allows.

Run: python -m scripts.many_models [--count 256]
"""

from __future__ import annotations

import argparse
from importlib.resources import files
from pathlib import Path

import mujoco
import mujoco.batch
import numpy as np

import mjfriction as mjf
from mjfriction.laws.law import Floats
from mjfriction.robot.friction_tables import FrictionTerm
from mjfriction.robot.robot import Robot
from mjfriction.sim.attach import candidate_blocks
from mjfriction.sim.reading import write_candidates

JOINT, SPEED, SECONDS = "elbow_joint", 1.5, 1.0  # rad/s, s
POSE = (0.0, -1.57, 0.0, 0.0, 0.0, 0.0)


def plausible(found: mjf.Identification, count: int, seed: int) -> list[Robot]:
    """Return identified robots with the joint's law drawn from the 95 % intervals of its parameters."""
    rng = np.random.default_rng(seed)
    law = next(one for one in found.laws if one.joint == JOINT)
    robots = []
    for _ in range(count):
        values = {
            own.name: float(np.clip(rng.normal(own.value, 0.25 * (own.high - own.low)), own.low, own.high))
            for own in law.parameters
        }
        term = FrictionTerm(law=law.fit.law.name, parameters=values)
        robots.append(found.robot.with_joint(found.robot.joint(JOINT).model_copy(update={"friction": (term,)})))
    return robots


def coasted(robots: list[Robot]) -> Floats:
    """Return how far the joint coasts on each robot without gravity, rad: (robots,).  All carry the same laws."""
    spec = mjf.robot_spec(robots[0])
    spec.option.gravity = np.zeros(3)
    model = mjf.attach(spec, mjf.robot_laws(robots[0]))
    place = model.joint(JOINT).qposadr[0]
    batch = mujoco.batch.Batch(model, len(robots), nthread=2)
    write_candidates(batch.expand("numeric_data"), model, candidate_blocks(model, list(map(mjf.robot_laws, robots))))
    batch.qpos[:] = POSE
    batch.qvel[:, model.joint(JOINT).dofadr[0]] = SPEED
    with mjf.friction_active():
        batch.step(nstep=round(SECONDS / model.opt.timestep))
    return np.asarray(batch.qpos[:, place]) - POSE[place]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=256)
    asked = parser.parse_args()
    stated = mjf.read_robot("ur5")
    log = mjf.read_log(Path(str(files("mjfriction"))) / "bundled/demo/log.parquet")
    found = mjf.identify_log(log, stated)
    print(found.summary)
    low, high = np.quantile(coasted(plausible(found, asked.count, seed=0)), [0.05, 0.95])
    print(f"{JOINT} coasts from {SPEED} rad/s, rad:")
    print(f"  as stated      {coasted([stated])[0]:.4f}")
    print(f"  as identified  {coasted([found.robot])[0]:.4f}")
    print(f"  {asked.count} plausible arms, nine in ten: {low:.4f} to {high:.4f}")


if __name__ == "__main__":
    main()
