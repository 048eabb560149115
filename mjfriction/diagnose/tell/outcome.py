"""The result of a diagnosis, as plain data."""

from __future__ import annotations

import enum
from collections.abc import Mapping
from dataclasses import dataclass

from mjfriction.diagnose.causes.cause import Picture
from mjfriction.diagnose.fit.extend import Adjustment
from mjfriction.diagnose.tell.free_run import FreeRun
from mjfriction.diagnose.tell.separate import Experiment
from mjfriction.identify.fitted import Fitted
from mjfriction.identify.gap import Gap
from mjfriction.identify.joint_error import JointError
from mjfriction.identify.proof import Gain
from mjfriction.identify.structure import Structure
from mjfriction.record.fault import Fault
from mjfriction.record.log import Floats
from mjfriction.robot.robot import Robot


class Verdict(enum.Enum):
    """The overall result of a diagnosis; the value is its name in a report."""

    EXPLAINED = "explained"
    CONSISTENT = "consistent"
    AMBIGUOUS = "ambiguous"
    UNEXPLAINED = "unexplained"
    BAD_DATA = "bad_data"


@dataclass(frozen=True)
class Finding:
    """A named cause: its joint (None for the whole arm), how certain and how large it is, and its held-out gain.

    ``shown_at`` is the joint where it shows best, ``picture`` what to draw there, and ``without`` (rows,) that joint's
    held-out residual with all other causes as they were fitted, but not this one.
    """

    cause: str
    joint: str | None
    confidence: float
    alternatives: tuple[str, ...]
    parameters: tuple[Fitted, ...]
    gain: Gain
    evidence: str
    covariate: str
    picture: Picture
    shown_at: str
    without: Floats


@dataclass(frozen=True, repr=False)
class Diagnosis:
    """Everything a diagnosis found.

    ``residual_after`` and ``heldout`` (rows, joints) are the residuals of the extended model, fitted to all rows and
    held-out; ``remaining`` names structure that no cause explains.  ``next_experiment`` is a motion that would
    distinguish an ambiguous finding from its likeliest alternative.  ``faults`` are those of the log itself, found
    before any physics is blamed.  ``gap`` is of the log as it should have been read; if that is not certain, the log is
    ``refused`` and nothing is fitted.  ``bandwidths`` (Hz, by joint) are those of drives that were found to low-pass
    their efforts; ``robot``, the extended robot, states them too.  ``free_run`` is the proof in motion; if it is None,
    ``not_run`` says why, unless the log was refused.
    """

    gap: Gap
    verdict: Verdict
    summary: str
    joints: tuple[JointError, ...]
    findings: tuple[Finding, ...]
    adjustments: tuple[Adjustment, ...]
    structure_before: tuple[Structure, ...]
    structure_after: tuple[Structure, ...]
    remaining: tuple[Structure, ...]
    faults: tuple[Fault, ...]
    refused: bool
    not_examined: tuple[str, ...]
    robot: Robot
    bandwidths: Mapping[str, float]
    next_experiment: Experiment | None
    residual_after: Floats
    heldout: Floats
    free_run: FreeRun | None
    not_run: str | None

    def __repr__(self) -> str:
        """Return the verdict and the summary."""
        return f"<Diagnosis {self.verdict.value}: {self.summary}>"
