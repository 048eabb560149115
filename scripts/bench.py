"""Measure the laws and the simulation, and write docs/benchmarks.md with its picture: make bench.

python -m scripts.bench            all of it, some minutes
python -m scripts.bench --small    one small case, printed and not written; what CI runs
"""

from __future__ import annotations

import argparse
import os
import platform
from importlib.metadata import version
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from scripts import law_costs, sim_accuracy, sim_speed

ROOT = Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs/benchmarks.md"
PICTURE = ROOT / "docs/images/accuracy.png"
COLOURS = {"mjfriction": "#1b80c4", "native dcmotor lugre": "#d1495b", "native frictionloss + damping": "#b7a26a"}


def machine() -> str:
    packages = ", ".join(f"{name} {version(name)}" for name in ("mujoco", "numba", "numpy"))
    return f"{os.cpu_count()} cores, {platform.machine()}, Python {platform.python_version()}, {packages}"


def accuracy_table(errors: dict[str, list[np.ndarray]], steps: tuple[float, ...]) -> str:
    lines = [f"| | {' | '.join(f'{1e3 * h:g} ms' for h in steps)} |", f"|---|{'---:|' * len(steps)}"]
    for way, found in errors.items():
        cells = [f"{np.max(e):.2g}" if np.isfinite(np.max(e)) else "breaks down" for e in found]
        lines.append(f"| {way} | {' | '.join(cells)} |")
    return "\n".join(lines)


def speed_table(rates: dict[str, np.ndarray]) -> str:
    lines = ["| integrator | ours / no friction | native / no friction | ours / native |", "|---|---:|---:|---:|"]
    for integrator in ("Euler", "implicitfast"):
        plain, own, native = (f"{integrator}, {what}" for what in ("no friction", "mjfriction", "native dcmotor lugre"))
        pairs = ((own, plain), (native, plain), (own, native))
        cells = [f"{sim_speed.ratio(rates, one, other):.2f}" for one, other in pairs]
        lines.append(f"| {integrator} | {' | '.join(cells)} |")
    return "\n".join(lines)


def speed_words(rates: dict[str, np.ndarray]) -> str:
    bare = "Euler, no friction, no callback"
    idle = float(np.median(rates["Euler, no friction"]) / np.median(rates[bare]))
    threads = sim_speed.ratio(rates, "Euler, mjfriction, two threads", "Euler, mjfriction")
    python = sim_speed.ratio(rates, "Euler, Python callback", bare)
    return (
        f"A model without friction runs at {idle:.2f} of its rate with the callback installed.\n"
        f"Two threads make {threads:.2f} times the steps of one.\n"
        f"The same laws called from a Python callback run at {python:.2f} of the frictionless rate, on one thread."
    )


def draw(rotor: dict[str, list[np.ndarray]], arm: dict[str, list[np.ndarray]], steps: tuple[float, ...]) -> None:
    figure = Figure(figsize=(9.0, 4.0), dpi=80, layout="constrained")
    for axis, (title, errors) in zip(
        figure.subplots(1, 2), (("NS12 rotor", rotor), ("UR5, worst axis", arm)), strict=True
    ):
        for way, found in errors.items():
            values = np.array([np.max(e) for e in found])
            shown = np.where(np.isfinite(values), values, np.nan)
            axis.loglog(1e3 * np.array(steps), shown, "o-", label=way, color=COLOURS.get(way, "#8a8d91"))
        axis.set_title(title, fontsize=10)
        axis.set_xlabel("time step, ms", fontsize=9)
        axis.set_ylabel("RMS position error, rad", fontsize=9)
        axis.grid(alpha=0.25, which="both")
        axis.tick_params(labelsize=8)
    handles, labels = axis.get_legend_handles_labels()
    figure.legend(handles, labels, frameon=False, fontsize=8, loc="outside lower center", ncols=4)
    figure.savefig(PICTURE, metadata={"Software": None})


def page(rotor: dict[str, list[np.ndarray]], arm: dict[str, list[np.ndarray]], rates: dict[str, np.ndarray]) -> str:
    steps = sim_accuracy.STEPS
    return f"""# Benchmarks

Written by `make bench` on one machine ({machine()}).
Rates are taken in turns and their ratios within each turn; what stands here are medians, and they move by some
hundredths from run to run.

## Accuracy in MuJoCo

RMS position error against the same law at very small steps; control at 1 kHz whatever the step. "The law's step, added
explicitly" is what one would write by hand: the law at the present velocity, its torque added as a force. The native
elements run under implicitfast; under Euler `dcmotor lugre=` breaks down on the rotor.

![RMS position error against the time step](images/accuracy.png)

One rotor with the NS12's joint-1 bristles under PD control, rad:

{accuracy_table(rotor, steps)}

A UR5 with laws of that stiffness on all six joints, computed torque and PD, the worst joint, rad:

{accuracy_table(arm, steps)}

## Speed in MuJoCo

Six LuGre joints in `mujoco.batch.Batch`, {sim_speed.SIMULATIONS} simulations of {sim_speed.STEPS} steps of 1 ms:

{speed_table(rates)}

{speed_words(rates)}

## Laws

[`docs/laws.md`](laws.md) has the cost of every law.
"""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--small", action="store_true", help="one small case, printed and not written")
    if parser.parse_args().small:
        print(law_costs.cost(law_costs.LAWS["lugre"]))
        case = sim_accuracy.six_axis_case()
        print(accuracy_table(sim_accuracy.table(case, (1e-3,)), (1e-3,)))
        rates = sim_speed.measure(steps=40, rounds=2)
        print(speed_table(rates), speed_words(rates), sep="\n")
        return
    rotor = sim_accuracy.table(sim_accuracy.rotor_case())
    arm = sim_accuracy.table(sim_accuracy.six_axis_case())
    rates = sim_speed.measure()
    draw(rotor, arm, sim_accuracy.STEPS)
    PAGE.write_text(page(rotor, arm, rates), encoding="utf-8")
    print(PAGE.read_text("utf-8"))


if __name__ == "__main__":
    main()
