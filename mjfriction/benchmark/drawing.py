"""How the benchmark's cases are drawn: the machine, the recording, the hidden effects.  Each seed is a case."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from mjfriction.benchmark.cases import SEVERITY, Case, Setting, make_case
from mjfriction.benchmark.effects.catalog import EFFECTS, Draw
from mjfriction.benchmark.effects.drive import coupling
from mjfriction.benchmark.effects.friction import pressure
from mjfriction.benchmark.effects.outside import OUTSIDE

ROBOTS = {
    "ur5": 0.3,
    "ur10": 0.2,
    "z1": 0.15,
    "comau_ns12": 0.15,
    "linear_axis": 0.08,
    "machine_table": 0.06,
    "hydraulic_cylinder": 0.06,
}
ARMS = ("ur5", "ur10", "z1", "comau_ns12")
COUNTS = {0: 0.15, 1: 0.55, 2: 0.2, 3: 0.1}
OUTSIDE_SHARE = 0.1  # share of cases that hide an effect outside all causes, alone or beside one cause
OIL_SECONDS = 40.0  # shorter than other logs, because a cylinder's oil takes ten steps a millisecond


@dataclass(frozen=True)
class Drawn:
    """What a seed draws: the setting, the effects to hide, and the name of the severity requested of each."""

    seed: int
    setting: Setting
    effects: tuple[Draw, ...]
    severity: str

    def case(self) -> Case:
        """Make the case."""
        return make_case(self.seed, self.setting, self.effects, SEVERITY[self.severity])


def draw_case(seed: int) -> Drawn:
    """Draw a case: the same seed always draws the same one."""
    rng = np.random.default_rng([seed, 51])
    robot = str(rng.choice(list(ROBOTS), p=list(ROBOTS.values())))
    setting = Setting(
        robot=robot,
        seconds=70.0,
        rate=float(rng.choice([250.0, 500.0])),
        noise=float(rng.choice([0.05, 0.1, 0.2])),
        encoder=float(2.0 * np.pi / 2 ** rng.integers(15, 20)),
        off=float(rng.choice([0.0, 0.03])),
        velocity=bool(rng.random() < 0.3),
        quantity="current" if rng.random() < 0.3 else "effort",
        motion="pick_and_place" if rng.random() < 0.2 else "excitation",
    )
    if robot not in ARMS:
        setting = replace(setting, motion="excitation")
    if robot == "hydraulic_cylinder":
        setting = replace(setting, quantity="effort", seconds=OIL_SECONDS, rate=250.0)
    count = int(rng.choice(list(COUNTS), p=list(COUNTS.values())))
    fitting = _fitting(robot)
    effects = tuple(fitting[i] for i in rng.permutation(len(fitting))[:count])
    if rng.random() < OUTSIDE_SHARE:
        effects = (*effects[:1], OUTSIDE[rng.integers(len(OUTSIDE))])
    return Drawn(seed, setting, effects, str(rng.choice(["medium", "large"])))


def _fitting(robot: str) -> tuple[Draw, ...]:
    # Cylinders, and only they, get pressed seals.  A joint without neighbours gets no coupling.
    if robot == "hydraulic_cylinder":
        return (pressure,)
    rest = tuple(draw for draw in EFFECTS if draw is not pressure)
    return rest if robot in ARMS else tuple(draw for draw in rest if draw is not coupling)
