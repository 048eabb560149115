"""The hidden-effect benchmark: make cases, run tools on them, score them, and write docs/hidden_effects.md.

Run: python -m scripts.hidden_effects --cases 200 --beside 60
Any command with the verbs ``diagnose`` and ``predict`` can be scored: --command "other-tool".
The results file has every finished case, so that an interrupted run can continue: --resume.
"""

from __future__ import annotations

import argparse
import shlex
import sys
import tempfile
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, replace
from pathlib import Path

from mjfriction.benchmark.drawing import draw_case
from mjfriction.benchmark.row import Row
from mjfriction.benchmark.tool import run_tool
from scripts.hidden_effects_page import page, picture

ROOT = Path(__file__).resolve().parent.parent
PAGE, PICTURE = ROOT / "docs/hidden_effects.md", ROOT / "docs/images/hidden_effects.png"
RESULTS = ROOT / "hidden_effects.jsonl"
OURS = "mjfriction"
PYTHON = shlex.quote(sys.executable)
TOOLS = {
    OURS: f"{PYTHON} -c 'from mjfriction.cli.main import run; run()'",
    "every term, t-test": f"{PYTHON} -m scripts.naive_baseline",
    "mujoco.sysid": f"{PYTHON} -m scripts.sysid_baseline",
}


def run_case(seed: int, tools: dict[str, str]) -> Row:
    """Make one case, run the tools on it, and return the outcomes."""
    drawn = draw_case(seed)
    case = drawn.case()
    outcomes = {}
    for name, command in tools.items():
        with tempfile.TemporaryDirectory() as folder:
            outcomes[name] = run_tool(shlex.split(command), case, Path(folder))
    reached = {f"{one.cause} {one.joint or ''}".strip(): one.severity for one in case.hidden}
    return Row(seed, asdict(drawn.setting), drawn.severity, reached, outcomes)


def done_before(results: Path, asked: dict[int, dict[str, str]]) -> dict[int, Row]:
    """Return the rows of a results file that need not be made again; ``asked`` are the tools to run by seed."""
    if not results.is_file():
        return {}
    rows = map(Row.read, results.read_text(encoding="utf-8").splitlines())
    kept = [row for row in rows if row.seed in asked and set(asked[row.seed]) <= set(row.outcomes)]
    return {row.seed: replace(row, outcomes={name: row.outcomes[name] for name in asked[row.seed]}) for row in kept}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cases", type=int, default=200)
    parser.add_argument("--first", type=int, default=620_000, help="seed of the first case")
    parser.add_argument("--command", help="a tool of your own to score in mjfriction's place")
    parser.add_argument("--beside", type=int, default=0, help="two other tools on so many of the first cases")
    parser.add_argument("--results", type=Path, default=RESULTS, help="every case as a line of JSON")
    parser.add_argument("--resume", action="store_true", help="keep the cases that the results file has")
    asked = parser.parse_args()
    own = {asked.command: asked.command} if asked.command else {OURS: TOOLS[OURS]}
    seeds = range(asked.first, asked.first + asked.cases)
    tools = {seed: {**own, **TOOLS} if k < asked.beside and not asked.command else own for k, seed in enumerate(seeds)}
    rows = done_before(asked.results, tools) if asked.resume else {}
    left = [seed for seed in seeds if seed not in rows]
    with ProcessPoolExecutor(2) as pool, asked.results.open("a" if asked.resume else "w", encoding="utf-8") as file:
        for row in pool.map(run_case, left, [tools[seed] for seed in left]):
            rows[row.seed] = row
            file.write(row.line() + "\n")
            file.flush()
    ordered = [rows[seed] for seed in seeds]
    for name in tools[asked.first]:
        said = [row.outcomes[name].verdict for row in ordered if name in row.outcomes]
        if all(verdict.startswith("failed") for verdict in said):
            parser.error(f"{name} {said[0]}; in every case, so that no page was written")
    text = page(ordered)
    if not asked.command and asked.cases >= 40:
        picture([row.ours for row in ordered], PICTURE)
        PAGE.write_text(text, encoding="utf-8")
    print(text)


if __name__ == "__main__":
    main()
