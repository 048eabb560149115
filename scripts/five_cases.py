"""Write docs/hidden_effects_five.md: five cases of the benchmark, each from the picture to the cause.

Run: python -m scripts.five_cases
"""

from __future__ import annotations

import textwrap
from dataclasses import dataclass
from pathlib import Path

import pyarrow as pa

from mjfriction.benchmark.cases import SEVERITY, Setting, draw_of, make_case
from mjfriction.diagnose.diagnosis import diagnose_log
from mjfriction.record.readers.table import log_from_table
from mjfriction.report.finding_figure import finding_figure
from scripts.pictures import draw_figure

ROOT = Path(__file__).resolve().parent.parent
PAGE, PICTURES = ROOT / "docs/hidden_effects_five.md", ROOT / "docs/images"

WIDTH = 118

INTRODUCTION = """# Five hidden effects, from the picture to the cause

Written by `python -m scripts.five_cases`. Each is a machine in closed loop with one effect hidden in it; mjfriction saw
the log and a robot file that knows nothing of it. Every picture shows what the log says beyond the robot file,
without the finding in the model and with it, against the quantity that the cause goes with; of waves, their spectrum.
"""


@dataclass(frozen=True)
class Told:
    """A case to show: what is hidden in which setting, and what a person sees in the picture."""

    title: str
    cause: str
    seed: int
    setting: Setting
    look: str


FIVE = (
    Told(
        "Friction that grows with the load",
        "friction.load",
        3,
        Setting("ur5", rate=250.0, noise=0.1, off=0.03),
        "The load is counted the way the joint moves: going with it on the right, against it on the left. The "
        "points lie on a slope through nothing: the more the joint carries, the more it rubs. A wrong Coulomb level "
        "would lift the right side and lower the left, and leave both flat.",
    ),
    Told(
        "Play in a gear",
        "drive.backlash",
        1003,
        Setting("comau_ns12", rate=250.0, noise=0.1),
        "Nothing is wrong as long as the load pushes one way. Where it changes sign the link lets go, flies for a "
        "moment, and lands on the other flank with a blow. A delay would show wherever the effort changes, not at "
        "these moments alone.",
    ),
    Told(
        "A table that cogs",
        "drive.cogging",
        12,
        Setting("machine_table", rate=500.0, noise=0.1),
        "One wavelength stands out: the same force returns at the same places. It does not turn when the table does; "
        "friction that varies along the stroke would, and no such line would stand here.",
    ),
    Told(
        "A joint that warms up",
        "friction.temperature",
        21,
        Setting("z1", rate=250.0, noise=0.1, off=0.03),
        "Counted against the motion, so that friction has one sign: the longer the joint has run, the less it rubs, "
        "and ever more slowly so, as it warms. A step in the level would have a moment.",
    ),
    Told(
        "Seals under pressure",
        "hydraulic.pressure",
        10,
        Setting("hydraulic_cylinder", seconds=40.0, rate=250.0, noise=0.1),
        "A level is missing in either direction, a larger one going in than going out; near rest, where the "
        "chambers press hardest, the points spread though the speed is the same. What is left follows the two "
        "pressures.",
    ),
)


def section(number: int, told: Told) -> str:
    """Return the section of a case and draw the pictures of its findings."""
    case = make_case(told.seed, told.setting, (draw_of(told.cause),), SEVERITY["large"])
    (hidden,) = case.hidden
    diagnosis = diagnose_log(log_from_table(pa.table(case.log), "the log"), case.stated)
    lines = [f"## {number}. {told.title}", ""]
    where = f" at `{hidden.joint}`" if hidden.joint else ""
    lines += [
        f"Hidden: `{hidden.cause}`{where} of `{told.setting.robot}`, {hidden.severity:.2g} times as large as the "
        "noise.",
        "",
        textwrap.fill(told.look, WIDTH),
    ]
    for k, finding in enumerate(diagnosis.findings):
        name = f"five_{number}{'' if k == 0 else f'_{k}'}.png"
        draw_figure(finding_figure(diagnosis, finding), PICTURES / name)
        lines += ["", f"![{finding.cause}](images/{name})", ""]
        values = "; ".join(
            f"{p.name} {p.value:.4g} ({p.low:.4g} to {p.high:.4g}){'' if p.unit == '1' else f' {p.unit}'}"
            for p in finding.parameters
        )
        found = (
            f"Found: `{finding.cause}`"
            + (f" at `{finding.joint}`" if finding.joint else "")
            + f": {finding.evidence}. "
            f"Parameters: {values}. On motion not fitted, the error at that joint falls from "
            f"{finding.gain.before:.3g} to {finding.gain.after:.3g}."
        )
        lines.append(textwrap.fill(found, WIDTH))
    return "\n".join([*lines, ""])


def main() -> None:
    parts = [section(number, told) for number, told in enumerate(FIVE, start=1)]
    PAGE.write_text("\n".join([INTRODUCTION, *parts]), encoding="utf-8")


if __name__ == "__main__":
    main()
