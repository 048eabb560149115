"""Scores of a tool that names causes: what it found compared with what was hidden."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

Named = tuple[str, str | None]

UNEXPLAINED = "unexplained"
AVOIDABLE = 0.02  # avoidable error, relative to the machine's own error, below which there is nothing to remove
BINS = 5
# A torque that depends on position is a spring by definition, although no spring has the shape of a stop.  So a soft
# stop that is reported as a spring is right too.
MAY_BE_TOLD_AS = {"outside.soft_stop": "body.spring"}


@dataclass(frozen=True)
class Finding:
    """A tool's finding: a cause at a joint, its confidence, and the causes that it could not tell it from."""

    cause: str
    joint: str | None
    confidence: float
    alternatives: tuple[str, ...] = ()

    def names(self, cause: str, joint: str | None) -> bool:
        """Whether this names a cause at its joint or as an alternative; whole-arm alternatives match any joint."""
        if (self.cause, self.joint) == (cause, joint):
            return True
        return cause in self.alternatives and (self.joint == joint or None in (self.joint, joint))


@dataclass(frozen=True)
class Outcome:
    """One case: what was ``hidden``, what was ``found``, and the ``seconds`` it took.

    ``removed`` is the share of the avoidable error that was removed on another motion, None where there was none.
    ``faint`` effects were hidden too, but add so little to the log that no tool is required to find them, nor blamed
    for finding them.  ``outside`` effects were hidden and match none of the causes: the verdict should be that
    structure is left, except for an effect that counts as one of the causes by definition.
    """

    hidden: tuple[Named, ...]
    found: tuple[Finding, ...]
    verdict: str
    removed: float | None
    seconds: float
    faint: tuple[Named, ...] = ()
    outside: tuple[Named, ...] = ()

    @property
    def left_open(self) -> bool:
        """Whether the verdict is that structure remains which no cause fits."""
        return self.verdict == UNEXPLAINED

    @property
    def open_in_vain(self) -> bool:
        """Whether the verdict is that structure remains although only causes were hidden."""
        return self.left_open and not self.outside

    @property
    def exact(self) -> bool:
        """Whether exactly the hidden causes were found, and an effect that no cause fits was left open."""
        found = {(finding.cause, finding.joint) for finding in self.found}
        if not self.left_open and not self._allowed <= found:
            return False
        return set(self.hidden) == found - {*self.faint, *self._allowed}

    @property
    def _allowed(self) -> set[Named]:
        # Effects outside all causes as they may be reported: such findings are neither required nor false alarms.
        return {self._told_as(*named) for named in self.outside}

    @staticmethod
    def _told_as(cause: str, joint: str | None) -> Named:
        return MAY_BE_TOLD_AS.get(cause, cause), joint

    @property
    def hit(self) -> bool:
        """Whether every hidden cause is, at its joint, a finding or an alternative of one."""
        return all(any(f.names(*named) for f in self.found) for named in self.hidden)

    def is_right(self, finding: Finding) -> bool:
        """Whether a finding is something that was hidden, faint or not."""
        return (finding.cause, finding.joint) in {*self.hidden, *self.faint, *self._allowed}

    @property
    def false_alarms(self) -> tuple[Finding, ...]:
        """Findings that do not name anything hidden, even as an alternative; changed friction levels do not count."""
        there = {*self.hidden, *self.faint, *self._allowed}
        return tuple(
            f
            for f in self.found
            if f.cause != "friction.coulomb_viscous" and not any(f.names(*named) for named in there)
        )


@dataclass(frozen=True)
class Score:
    """Shares and medians over many cases."""

    cases: int
    exact: float
    hit: float
    named: float
    false_alarm: float
    open_in_vain: float
    removed: float
    seconds: float


def score(outcomes: Sequence[Outcome]) -> Score:
    """Return the score of many cases.

    Shares: of exact cases, of hits, of hidden causes that are named, of cases with a structural false alarm, and of the
    cases with nothing outside all causes, those left open in vain.  Medians: of the share of avoidable error removed
    and of the seconds.
    """
    named = [any(f.names(*cause) for f in one.found) for one in outcomes for cause in one.hidden]
    in_vain = [one.open_in_vain for one in outcomes if not one.outside]
    removed = [one.removed for one in outcomes if one.removed is not None]
    return Score(
        cases=len(outcomes),
        exact=float(np.mean([one.exact for one in outcomes])),
        hit=float(np.mean([one.hit for one in outcomes])),
        named=float(np.mean(named)) if named else float("nan"),
        false_alarm=float(np.mean([bool(one.false_alarms) for one in outcomes])),
        open_in_vain=float(np.mean(in_vain)) if in_vain else float("nan"),
        removed=float(np.median(removed)) if removed else float("nan"),
        seconds=float(np.nanmedian([one.seconds for one in outcomes])),
    )


def reliability(outcomes: Sequence[Outcome]) -> list[tuple[float, float, int]]:
    """Return mean confidence, share of right findings and their number in bins of confidence."""
    pairs = [(f.confidence, one.is_right(f)) for one in outcomes for f in one.found]
    out = []
    for k in range(BINS):
        low, high = k / BINS, (k + 1) / BINS + 1e-9 * (k == BINS - 1)
        inside = [(c, right) for c, right in pairs if low <= c < high]
        if inside:
            confidence, right = np.mean(np.array(inside, dtype=float), axis=0)
            out.append((float(confidence), float(right), len(inside)))
    return out


def removed_share(measured: np.ndarray, stated: np.ndarray, extended: np.ndarray, machine: np.ndarray) -> float | None:
    """Return (stated − extended)/(stated − machine) of the RMS errors, each joint's in units of the machine's own.

    All arrays have shape (n, joints); rows with NaN are left out.  None where the stated robot is nearly as good as the
    machine itself.
    """
    whole = np.all(np.isfinite(stated), axis=1)
    errors = [np.sqrt(np.mean(np.square(measured - p)[whole], axis=0)) for p in (stated, extended, machine)]
    unit = np.where(errors[2] > 0.0, errors[2], 1.0)
    before, after, best = (float(np.sqrt(np.mean(np.square(e / unit)))) for e in errors)
    return (before - after) / (before - best) if before - best > AVOIDABLE * best else None
