"""The page of the hidden-effect benchmark: its tables, and the picture of the confusion between causes."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path

import matplotlib as mpl
import numpy as np

mpl.use("Agg")
import matplotlib.pyplot as plt

from mjfriction.benchmark.cases import FAINT, OUTLYING
from mjfriction.benchmark.drawing import ARMS
from mjfriction.benchmark.row import Row
from mjfriction.benchmark.score import MAY_BE_TOLD_AS, Named, Outcome, reliability, score

FOUND, ALTERNATIVE, MISSED = "found", "alternative", "missed"

PAGE_TEXT = """# Hidden effects: how often the cause is named

Made by `{command} --cases {count} --first {first}{beside}`; seeds make cases, so anybody can make the same ones.
[Five of them, from the picture to the cause](hidden_effects_five.md).

Each case is a machine in closed loop in MuJoCo: an arm of six axes, a linear axis, a table or a cylinder, 70 s of
sums of sines or of moves from pose to pose, noise of 5 to 20 % of each joint's Coulomb level, encoders of 15 to 19
bit, 250 or 500 Hz, efforts or currents, velocity measured or not. None, one, two or three effects are hidden in it,
sometimes one that no cause of the table is; the robot file knows nothing of them, and its masses and levels may be 3
% off. A second log is of another motion. The severity of an effect is the RMS it adds at the joint where it shows
most over that joint's noise: about 1.5 is medium, 4 is large; some effects cannot reach that much within what is
physical, and a machine that its controller cannot hold is made again with half of it. One that adds less than {faint}
of the noise, or changes a stated value by less than {outlying:g} times what that machine's stated values are off by
anyway, is asked of no tool and held against none ({drawn} were drawn here). The effects are the plant's own parts, but
friction laws and rigid bodies are the ones that the diagnosis knows: logs of other physics will be harder.

*Exact*: just what was hidden was found, and what no cause fits was left open (or, of a soft stop, told as the
`body.spring` that a torque in position is by definition). *Hit*: every hidden cause is, at its
joint, a finding or an alternative of one. *Named*: the share of the hidden causes that are. *False alarm*: a finding
of something else that has nothing hidden among its alternatives, changed friction levels aside. *Open in vain*: of
the logs with nothing outside all causes, those of which it was said that something remains which none explains.
*Error removed*: the share of the avoidable prediction error on the other motion that the extended robot takes away
(median). Seconds are of the whole command, two at a time on a machine of two cores; mjfriction's include its report
page and recording.{on_first}

{tools}

{table}

{outside}

{causes}

![confusion and reliability](images/hidden_effects.png)

## Your own tool

`{command} --command other-tool` runs any command that has the verbs `diagnose LOG --robot R --out DIR` and
`predict LOG --robot R --out P.parquet` and scores it alike; of `DIR/report.json` it reads `verdict`, and `cause`,
`joint`, `confidence` and `alternatives` of the `findings`. `mjfriction.benchmark.cases.write_case` writes a case as a
folder: `log.parquet` and `robot.toml` for the tool; what was hidden, the machine itself and the other log apart, in
`truth/`.
"""


def told_as(one: Outcome, named: Named) -> str:
    """Return how a tool reported a hidden cause."""
    if named in [(f.cause, f.joint) for f in one.found]:
        return FOUND
    return ALTERNATIVE if any(f.names(*named) for f in one.found) else MISSED


def picture(outcomes: list[Outcome], target: Path) -> None:
    """Draw the confusion between causes, and the reliability of the confidence."""
    causes = sorted(
        {cause for one in outcomes for cause, _ in (*one.hidden, *one.outside)}
        | {f.cause for o in outcomes for f in o.found}
    )
    counts = np.zeros((len(causes) + 1, len(causes) + 2))
    for one in outcomes:
        for named in one.hidden:
            row = causes.index(named[0])
            counts[row, {FOUND: row, ALTERNATIVE: -2, MISSED: -1}[told_as(one, named)]] += 1
        for cause, joint in one.outside:
            alike = MAY_BE_TOLD_AS.get(cause, cause)
            told = alike if (alike, joint) in {(f.cause, f.joint) for f in one.found} else cause
            counts[causes.index(cause), causes.index(told) if one.left_open or told != cause else -1] += 1
        for f in one.false_alarms:
            counts[-1, causes.index(f.cause)] += 1
    figure, (left, right) = plt.subplots(1, 2, figsize=(16, 9), width_ratios=[2, 1], layout="constrained")
    left.imshow(counts, cmap="Blues", vmin=0)
    for (i, k), count in np.ndenumerate(counts):
        if count:
            dark = count >= counts.max() / 2
            left.text(k, i, f"{count:.0f}", ha="center", va="center", color="white" if dark else "black")
    left.set_xticks(range(len(causes) + 2), [*causes, "(as an alternative)", "(missed)"], rotation=90)
    left.set_yticks(range(len(causes) + 1), [*causes, "(nothing there)"])
    left.set_xlabel("found; of what is outside all causes: left open, or what it may be told as")
    left.set_ylabel("hidden")
    points = reliability(outcomes)
    right.plot([0, 1], [0, 1], color="0.7")
    right.plot([p[0] for p in points], [p[1] for p in points], "o-")
    for confidence, share, count in points:
        right.annotate(f"{count}", (confidence, share), textcoords="offset points", xytext=(6, -10))
    right.set_xlabel("confidence said")
    right.set_ylabel("share of findings that were right")
    right.set_aspect("equal")
    figure.savefig(target, dpi=80, metadata={"Software": None})
    plt.close(figure)


HEAD = [
    "| {} | number | exact | hit | named | false alarm | open in vain | error removed | seconds |",
    f"|---|{'---:|' * 8}",
]


def scores(first: str, groups: Iterable[tuple[str, Sequence[Outcome]]]) -> str:
    """Return a table of the scores of groups of outcomes."""
    lines = [HEAD[0].format(first), HEAD[1]]
    for name, chosen in groups:
        if chosen:
            s = score(chosen)
            removed = "" if np.isnan(s.removed) else f"{s.removed:.2f}"
            named, vain = ("" if np.isnan(share) else f"{100 * share:.0f} %" for share in (s.named, s.open_in_vain))
            lines.append(
                f"| {name} | {s.cases} | {100 * s.exact:.0f} % | {100 * s.hit:.0f} % | {named} | "
                f"{100 * s.false_alarm:.0f} % | {vain} | {removed} | {s.seconds:.1f} |"
            )
    return "\n".join(lines)


def grouped(rows: list[Row]) -> Iterable[tuple[str, list[Outcome]]]:
    """Return the groups of cases that the page distinguishes, by name."""

    def those(holds: Callable[[Row], bool]) -> list[Outcome]:
        return [row.ours for row in rows if holds(row)]

    yield "all", [row.ours for row in rows]
    yield "stated model right", those(lambda r: r.setting["off"] == 0.0)
    yield "stated model 3 % off", those(lambda r: r.setting["off"] > 0.0)
    yield "six axes, stated model right", those(lambda r: r.setting["robot"] in ARMS and r.setting["off"] == 0.0)
    yield "six axes, stated model 3 % off", those(lambda r: r.setting["robot"] in ARMS and r.setting["off"] > 0.0)
    yield "nothing hidden", those(lambda r: not (r.ours.hidden or r.ours.faint or r.ours.outside))
    for count, word in ((1, "one effect"), (2, "two effects"), (3, "three effects")):
        yield word, those(lambda r, n=count: len(r.ours.hidden) == n and not r.ours.outside)
    yield "an effect outside all causes", those(lambda r: bool(r.ours.outside))
    for severity in ("medium", "large"):
        yield severity, those(lambda r, s=severity: r.severity == s and bool(r.ours.hidden))
    for noise in sorted({row.setting["noise"] for row in rows}):
        yield f"noise {100 * noise:.0f} % of Coulomb", those(lambda r, n=noise: r.setting["noise"] == n)
    for key in ("robot", "motion", "quantity"):
        for value in sorted({row.setting[key] for row in rows}):
            yield f"`{value}`", those(lambda r, k=key, v=value: r.setting[k] == v)


def page(rows: list[Row]) -> str:
    """Return the page."""
    outcomes = [row.ours for row in rows]
    told = Counter((named[0], told_as(one, named)) for one in outcomes for named in one.hidden)
    causes = ["| cause | hidden | named | as an alternative |", "|---|---:|---:|---:|"]
    for cause in sorted({cause for cause, _ in told}):
        found, alike, missed = (told[cause, how] for how in (FOUND, ALTERNATIVE, MISSED))
        causes.append(f"| `{cause}` | {found + alike + missed} | {found} | {alike or ''} |")
    outside = ["| outside all causes | hidden | left open | with a false alarm |", "|---|---:|---:|---:|"]
    for cause in sorted({c for one in outcomes for c, _ in one.outside}):
        own = [one for one in outcomes if cause in {c for c, _ in one.outside}]
        open_, false = sum(one.left_open for one in own), sum(bool(one.false_alarms) for one in own)
        outside.append(f"| {cause.partition('.')[2].replace('_', ' ')} | {len(own)} | {open_} | {false} |")
    names = list(rows[0].outcomes)
    shared = [row for row in rows if set(names) <= set(row.outcomes)]
    tools = scores("tool", [(name, [row.outcomes[name] for row in shared]) for name in names])
    on_first = f" The other tools were run on the first {len(shared)} cases." if len(shared) < len(rows) else ""
    return PAGE_TEXT.format(
        count=len(rows),
        first=rows[0].seed,
        beside=f" --beside {len(shared)}" if len(names) > 1 else "",
        on_first=on_first if len(names) > 1 else "",
        faint=FAINT,
        outlying=OUTLYING,
        drawn=sum(len(one.faint) for one in outcomes),
        tools=tools if len(names) > 1 else "",
        table=scores("cases", grouped(rows)),
        outside="\n".join(outside) if len(outside) > 2 else "",
        causes="\n".join(causes),
        command="python -m scripts.hidden_effects",
    )
