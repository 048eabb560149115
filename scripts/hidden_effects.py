"""The hidden-effect benchmark: make cases, run a tool on them, score it, and write docs/hidden_effects.md.

Run: python -m scripts.hidden_effects --cases 80
Any command with the verbs ``diagnose`` and ``predict`` can be scored: --command "other-tool".
"""

from __future__ import annotations

import argparse
import json
import shlex
import subprocess
import sys
import tempfile
import time
from collections import Counter
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict
from functools import partial
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pyarrow.parquet

mpl.use("Agg")
import matplotlib.pyplot as plt

from mjfriction.benchmark.cases import SEVERITY, Setting, make_case, write_case
from mjfriction.benchmark.effects.catalog import EFFECTS
from mjfriction.benchmark.score import Finding, Outcome, reliability, removed_share, score

ROOT = Path(__file__).resolve().parent.parent
PAGE, PICTURE = ROOT / "docs/hidden_effects.md", ROOT / "docs/images/hidden_effects.png"
ROBOTS = ("ur5", "ur5", "ur10", "z1")
FAINT = 0.5  # of the noise, that an effect must add where it shows most for a tool to be asked for it
OURS = f"{shlex.quote(sys.executable)} -c 'from mjfriction.cli.main import run; run()'"


PAGE_TEXT = """# Hidden effects: how often the cause is named

Made by `{command} --cases {count} --first {first}`; seeds make cases, so anybody can make the same ones.

Each case is a machine in closed loop in MuJoCo (70 s of motion of all joints, noise of 5 to 20 % of each joint's
Coulomb level, encoders of 15 to 19 bit, 250 or 500 Hz) with none, one or two effects hidden in it, a robot file that
knows nothing of them, and a second log of another motion. The severity of an effect is the RMS it adds at the joint
where it shows most over that joint's noise: about 1.5 is medium, 4 is large; some effects cannot reach that much within
what is physical. One that adds less than {faint} of the noise ({drawn} were drawn here) is asked of no tool and held
against none. The effects are the plant's own parts, but friction laws and rigid bodies are the ones that the diagnosis
knows: logs of other physics will be harder.

*Exact*: just what was hidden was found. *Hit*: every hidden cause is, at its joint, a finding or an alternative of one.
*False alarm*: a finding of something else, changed friction levels aside. *Error removed*: the share of the avoidable
prediction error on the other motion that the extended robot takes away (median). Seconds are of the whole command,
report page and recording included, two at a time on a machine of two cores.

{table}

{causes}

![confusion and reliability](images/hidden_effects.png)

## Your own tool

`{command} --command other-tool` runs any command that has the verbs `diagnose LOG --robot R --out DIR` and
`predict LOG --robot R --out P.parquet` and scores it alike. `mjfriction.benchmark.cases.write_case` writes a case as a
folder: `log.parquet` and `robot.toml` for the tool; what was hidden, the machine itself and the other log apart, in
`truth/`.
"""


def draw(seed: int) -> tuple[Setting, tuple, str]:
    """Draw the setting, the effects and the severity of a case."""
    rng = np.random.default_rng([seed, 51])
    setting = Setting(
        robot=str(rng.choice(ROBOTS)),
        seconds=70.0,
        rate=float(rng.choice([250.0, 500.0])),
        noise=float(rng.choice([0.05, 0.1, 0.2])),
        encoder=float(2.0 * np.pi / 2 ** rng.integers(15, 20)),
        off=float(rng.choice([0.0, 0.03])),
        velocity=bool(rng.random() < 0.3),
    )
    count = int(rng.choice([0, 1, 1, 1, 1, 2]))
    effects = tuple(EFFECTS[i] for i in rng.choice(len(EFFECTS), count, replace=False))
    return setting, effects, str(rng.choice(["medium", "large"]))


def run_case(seed: int, command: list[str]) -> tuple[int, Setting, str, Outcome, list[float]]:
    """Make one case, run the tool on it, and say what came of it."""
    setting, effects, severity = draw(seed)
    case = make_case(seed, setting, effects, SEVERITY[severity])
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        write_case(case, folder)
        start = time.perf_counter()
        words = ["diagnose", folder / "log.parquet", "--robot", folder / "robot.toml", "--out", folder / "out"]
        subprocess.run([*command, *map(str, words)], check=True, capture_output=True)
        seconds = time.perf_counter() - start
        report = json.loads((folder / "out/report.json").read_text())
        predicted = []
        for k, robot in enumerate((folder / "robot.toml", folder / "out/robot.toml", folder / "truth/robot.toml")):
            out = folder / f"predicted{k}.parquet"
            words = ["predict", folder / "truth/other.parquet", "--robot", robot, "--out", out]
            subprocess.run([*command, *map(str, words)], check=True, capture_output=True)
            table = pyarrow.parquet.read_table(out)
            predicted.append(np.column_stack([table[f"effort.{joint}"] for joint in case.stated.joints]))
        measured = np.column_stack([case.other[f"effort.{joint}"] for joint in case.stated.joints])
    found = tuple(
        Finding(f["cause"], f["joint"], f["confidence"], tuple(f["alternatives"])) for f in report["findings"]
    )
    hidden = tuple((one.cause, one.joint) for one in case.hidden if one.severity >= FAINT)
    faint = tuple((one.cause, one.joint) for one in case.hidden if one.severity < FAINT)
    removed = removed_share(measured, *predicted) if hidden else None
    reached = [one.severity for one in case.hidden]
    return seed, setting, severity, Outcome(hidden, found, report["verdict"], removed, seconds, faint), reached


def picture(outcomes: list[Outcome]) -> None:
    """Draw who was taken for whom, and how far confidence can be trusted."""
    causes = sorted(
        {cause for one in outcomes for cause, _ in one.hidden} | {f.cause for o in outcomes for f in o.found}
    )
    counts = np.zeros((len(causes) + 1, len(causes) + 1))
    for one in outcomes:
        found = [(f.cause, f.joint) for f in one.found]
        for cause, joint in one.hidden:
            row = causes.index(cause)
            if (cause, joint) in found:
                counts[row, row] += 1
            else:
                counts[row, -1] += 1
        for f in one.false_alarms:
            counts[-1, causes.index(f.cause)] += 1
    figure, (left, right) = plt.subplots(1, 2, figsize=(15, 8), width_ratios=[2, 1], layout="constrained")
    left.imshow(counts, cmap="Blues", vmin=0)
    for (i, k), count in np.ndenumerate(counts):
        if count:
            left.text(
                k, i, f"{count:.0f}", ha="center", va="center", color="black" if count < counts.max() / 2 else "white"
            )
    left.set_xticks(range(len(causes) + 1), [*causes, "(missed)"], rotation=90)
    left.set_yticks(range(len(causes) + 1), [*causes, "(nothing there)"])
    left.set_xlabel("found")
    left.set_ylabel("hidden")
    points = reliability(outcomes)
    right.plot([0, 1], [0, 1], color="0.7")
    right.plot([p[0] for p in points], [p[1] for p in points], "o-")
    for confidence, share, count in points:
        right.annotate(f"{count}", (confidence, share), textcoords="offset points", xytext=(6, -10))
    right.set_xlabel("confidence said")
    right.set_ylabel("share of findings that were right")
    right.set_aspect("equal")
    figure.savefig(PICTURE, dpi=80)


def page(rows: list[tuple[int, Setting, str, Outcome, list[float]]], first: int) -> str:
    """Return the page."""
    groups = {
        "all": rows,
        "stated model right": [r for r in rows if r[1].off == 0.0],
        "stated model 3 % off": [r for r in rows if r[1].off > 0.0],
        "nothing hidden": [r for r in rows if not r[3].hidden and not r[3].faint],
        "one effect": [r for r in rows if len(r[3].hidden) == 1],
        "two effects": [r for r in rows if len(r[3].hidden) == 2],
        **{name: [r for r in rows if r[1].robot == name] for name in sorted(set(ROBOTS))},
        "medium": [r for r in rows if r[2] == "medium" and r[3].hidden],
        "large": [r for r in rows if r[2] == "large" and r[3].hidden],
    }
    table = ["| cases | number | exact | hit | false alarm | error removed | seconds |", f"|---|{'---:|' * 6}"]
    for name, chosen in groups.items():
        if chosen:
            s = score([r[3] for r in chosen])
            removed = "" if np.isnan(s.removed) else f"{s.removed:.2f}"
            table.append(
                f"| {name} | {s.cases} | {100 * s.exact:.0f} % | {100 * s.hit:.0f} % | {100 * s.false_alarm:.0f} % | "
                f"{removed} | {s.seconds:.1f} |"
            )
    missed = Counter(c for r in rows for c, j in r[3].hidden if (c, j) not in {(f.cause, f.joint) for f in r[3].found})
    asked = Counter(c for r in rows for c, _ in r[3].hidden)
    causes = ["| cause | hidden | named |", "|---|---:|---:|"]
    causes += [f"| `{cause}` | {count} | {count - missed[cause]} |" for cause, count in sorted(asked.items())]
    return PAGE_TEXT.format(
        count=len(rows),
        first=first,
        faint=FAINT,
        drawn=sum(len(r[3].faint) for r in rows),
        table="\n".join(table),
        causes="\n".join(causes),
        command="python -m scripts.hidden_effects",
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cases", type=int, default=80)
    parser.add_argument("--first", type=int, default=50_000, help="seed of the first case")
    parser.add_argument("--command", default=OURS)
    parser.add_argument("--results", type=Path, help="write every case as JSON here")
    asked = parser.parse_args()
    command = shlex.split(asked.command)
    with ProcessPoolExecutor(2) as pool:
        rows = list(pool.map(partial(run_case, command=command), range(asked.first, asked.first + asked.cases)))
    if asked.results:
        listed = [
            {"seed": r[0], "setting": asdict(r[1]), "severity": r[2], "reached": r[4], **asdict(r[3])} for r in rows
        ]
        asked.results.write_text(json.dumps(listed, indent=1) + "\n", encoding="utf-8")
    if asked.command == OURS and asked.cases >= 40:
        picture([r[3] for r in rows])
        PAGE.write_text(page(rows, asked.first), encoding="utf-8")
    print(page(rows, asked.first))


if __name__ == "__main__":
    main()
