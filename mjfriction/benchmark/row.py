"""The outcomes of one case for every tool that was run on it: a line of a results file."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from typing import Any

from mjfriction.benchmark.score import Finding, Outcome


@dataclass(frozen=True)
class Row:
    """What was drawn for a seed (``setting``, ``severity``), the severity ``reached`` by each hidden effect, and the
    ``outcomes`` by tool.
    """

    seed: int
    setting: dict[str, Any]
    severity: str
    reached: dict[str, float]
    outcomes: dict[str, Outcome]

    @property
    def ours(self) -> Outcome:
        """The outcome of the first tool."""
        return next(iter(self.outcomes.values()))

    def line(self) -> str:
        """Return the row as a line of JSON."""
        return json.dumps({**vars(self), "outcomes": {name: asdict(one) for name, one in self.outcomes.items()}})

    @staticmethod
    def read(line: str) -> Row:
        """Read what :meth:`line` wrote."""
        table = json.loads(line)
        table["outcomes"] = {name: _outcome(one) for name, one in table["outcomes"].items()}
        return Row(**table)


def _outcome(table: dict[str, Any]) -> Outcome:
    for name in ("hidden", "faint", "outside"):
        table[name] = tuple((cause, joint) for cause, joint in table[name])
    found = [{**one, "alternatives": tuple(one["alternatives"])} for one in table["found"]]
    table["found"] = tuple(Finding(**one) for one in found)
    return Outcome(**table)
