"""Scores of a tool that names causes: what it found beside what was hidden."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

Named = tuple[str, str | None]

UNEXPLAINED = "unexplained"
AVOIDABLE = 0.02  # of the error as stated, relative to the machine's own, below which there was nothing to remove
BINS = 5
# A torque in position is a spring by definition, though no spring has a stop's form: told as one it is right as well.
MAY_BE_TOLD_AS = {"outside.soft_stop": "body.spring"}


@dataclass(frozen=True)
class Finding:
    """What a tool said: a cause at a joint, how sure it was, and what it could not tell it from."""

    cause: str
    joint: str | None
    confidence: float
    alternatives: tuple[str, ...] = ()

    def names(self, cause: str, joint: str | None) -> bool:
        """Whether this names a cause at its joint, or as an alternative, whose joint may be any in the whole arm's."""
        if (self.cause, self.joint) == (cause, joint):
            return True
        return cause in self.alternatives and (self.joint == joint or None in (self.joint, joint))


@dataclass(frozen=True)
class Outcome:
    """One case: what was hidden, what was found, the share of the avoidable error removed on another motion (None where
    there was none), and the seconds it took.

    ``faint`` was hidden too, but adds so little to the log that it is asked of no tool, and held against none.
    ``outside`` is what was hidden and is none of the causes: the verdict should be that structure is left, but for what
    one of the causes is by definition.
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
        """Whether that is the verdict though nothing was hidden but causes."""
        return self.left_open and not self.outside

    @property
    def exact(self) -> bool:
        """Whether just what was hidden was found, and what no cause fits was left open."""
        found = {(finding.cause, finding.joint) for finding in self.found}
        if not self.left_open and not self._allowed <= found:
            return False
        return set(self.hidden) == found - {*self.faint, *self._allowed}

    @property
    def _allowed(self) -> set[Named]:
        # What an effect outside all causes may be told as, and be neither asked for nor a false alarm.
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
        """Findings of what was not hidden, nor is an alternative; the stated levels of friction aside."""
        there = {*self.hidden, *self.faint, *self._allowed}
        return tuple(
            f
            for f in self.found
            if f.cause != "friction.coulomb_viscous" and not any(f.names(*named) for named in there)
        )


@dataclass(frozen=True)
class Score:
    """Shares over many cases."""

    cases: int
    exact: float
    hit: float
    named: float
    false_alarm: float
    open_in_vain: float
    removed: float
    seconds: float


def score(outcomes: Sequence[Outcome]) -> Score:
    """Return the shares of exact cases, of hits, of hidden causes that are named, of cases with a structural false
    alarm, of those with nothing outside all causes that were left open in vain, and the medians of the share of
    avoidable error removed and of the seconds.
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
