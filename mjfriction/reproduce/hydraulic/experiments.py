"""The cylinder follows its reference: under PD, and with friction known from a law or from observers."""

from __future__ import annotations

from dataclasses import dataclass

from mjfriction.control.valve import FrictionSource, ValveGains
from mjfriction.progress import Tell, counting
from mjfriction.reproduce.hydraulic.identified import (
    Identified,
    identify_cylinder,
    separate_gains,
    tuned_acceleration,
    tuned_pd,
)
from mjfriction.reproduce.hydraulic.machine import (
    HEAVY,
    LOW_SUPPLY,
    OBSERVERS,
    SHARP,
    Tracked,
    cylinder,
    follow,
)

LAW = "identified law"


@dataclass(frozen=True)
class Compared:
    """One controller: the source of its friction, its gains (equal in both directions), and its runs by name."""

    friction: FrictionSource | None
    gains: ValveGains
    runs: dict[str, Tracked]


def run_cylinder(tell: Tell, seed: int = 0) -> tuple[Identified, dict[str, Compared], tuple[ValveGains, ValveGains]]:
    """Identify the cylinder, tune every controller, follow the reference with each; ``tell`` is called at each step.

    The last value returned is the gains of the variable-structure observer's controller, separate for the directions.
    """
    begin = counting(tell, 3 + 2 * (2 + len(OBSERVERS)))
    begin("identifying the cylinder")
    identified = identify_cylinder(seed)
    sources: dict[str, FrictionSource | None] = {"PD": None, LAW: identified.law(), **OBSERVERS}
    heavy, compared = cylinder(mass=HEAVY), {}
    for name, source in sources.items():
        begin(f"tuning {name}")
        gains = tuned_pd(seed) if source is None else tuned_acceleration(source, seed)
        begin(f"following the reference: {name}")
        pair = (gains, gains)
        runs = {
            "nominal": follow(pair, source, periods=2.0, seed=seed),
            "20 bar": follow(pair, source, supply=LOW_SUPPLY, seed=seed),
            "96 kg": follow(pair, source, machine=heavy, seed=seed),
        }
        compared[name] = Compared(source, gains, runs)
    best = compared["variable structure"]
    begin("separate gains")
    assert best.friction is not None
    separate = separate_gains(best.gains, best.friction, seed)
    best.runs["separate gains"] = follow(separate, best.friction, periods=2.0, seed=seed)
    begin("sharp switching, and the law as printed")
    best.runs["sharp"] = follow((best.gains, best.gains), SHARP, periods=2.0, seed=seed)
    law = compared[LAW]
    law.runs["as printed"] = follow((law.gains, law.gains), identified.law(3), periods=2.0, seed=seed)
    return identified, compared, separate
