"""report.json of a diagnosis: its machine-readable form."""

from __future__ import annotations

from importlib.metadata import version
from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, PlainSerializer

from mjfriction.diagnose.tell.outcome import Diagnosis, Finding
from mjfriction.identify.colour import NOTHING
from mjfriction.identify.falling import FASTER
from mjfriction.identify.fitted import Fitted
from mjfriction.identify.gap import Gap
from mjfriction.identify.structure import Structure
from mjfriction.record.fault import Fault, moment
from mjfriction.report.digits import kept

SCHEMA: Literal["mjfriction.report/1"] = "mjfriction.report/1"

# Seven digits: more than any log carries, and few enough to hide differences in the last bits between libraries.
Number = Annotated[float, PlainSerializer(kept, return_type=float)]
Interval = tuple[Number, Number]

UNEVEN = 0.12  # relative spread of a clock's steps above which it is reported: less is usual for computers' timestamps


class Entry(BaseModel):
    """A table of the report; unknown keys are rejected when a report is read back."""

    model_config = ConfigDict(extra="forbid", frozen=True)


class JointEntry(Entry):
    """RMS errors of one joint; ``heldout`` ones are on motion that the extended robot was not fitted to."""

    joint: str
    signal: Literal["effort", "current"]
    unit: str
    rms_before: Number
    rms_after: Number
    rms_heldout_before: Number
    rms_heldout_after: Number
    noise_floor: Number
    reduction_ci95: Interval | None = None


class ParameterEntry(Entry):
    """A fitted quantity with its 95 % interval."""

    name: str
    value: Number
    unit: str
    ci95: Interval
    meaning: str = ""
    note: str = ""


class GainEntry(Entry):
    """The held-out reduction of a joint's error by one finding."""

    rms_before: Number
    rms_after: Number
    reduction: Number
    ci95: Interval


class FindingEntry(Entry):
    """A named cause."""

    cause: str
    joint: str | None
    confidence: Annotated[Number, Field(ge=0.0, le=1.0)]
    alternatives: list[str]
    parameters: list[ParameterEntry]
    gain: GainEntry
    evidence: str


class DataProblem(Entry):
    """A fault of the log itself, where it is, and what was done about it."""

    kind: str
    where: str
    action: str


class DriftEntry(Entry):
    """A joint's position error in free runs (RMS), as stated and extended, and the reduction by the extended robot."""

    joint: str
    unit: str
    rms_before: Number
    rms_after: Number
    reduction: Number
    ci95: Interval


class SimulationEntry(Entry):
    """The stated and the extended robot in MuJoCo, driven freely by the log's efforts.

    There are ``runs`` of ``seconds`` each, on motion that the extended robot was not fitted to.
    """

    seconds: Number
    runs: int
    joints: list[DriftEntry]


class AdjustmentEntry(Entry):
    """A stated value that was refitted along in the extended robot, without being a finding."""

    what: str
    joint: str
    unit: str
    stated: Number
    fitted: Number
    ci95: Interval


class StructureEntry(Entry):
    """The share of a joint's squared error that a smooth curve over one covariate predicts, before and after."""

    joint: str
    covariate: str
    share_before: Number
    share_after: Number


class CandidateEntry(Entry):
    """A law that was tried on a joint, its number of parameters, and its held-out RMS error."""

    law: str
    parameters: int
    rms_heldout: Number


class PassEntry(Entry):
    """Friction of a joint at one speed, from forward and backward passes."""

    speed: Number
    friction: Number
    spread: Number


class LawEntry(Entry):
    """A friction law identified at a joint.

    ``by_slope`` are the values of law (14) by the slope near zero, where that was fitted.  ``falls``: friction still
    falls at the fastest speed of the log.  ``apart_by_pendulum`` (N·m), where there are passes: half the difference of
    forward and backward friction (RMS) if gravity is removed as a pendulum's, first the stated model's, then a fitted
    one.
    """

    joint: str
    law: str
    side: Literal["joint", "motor"]
    how: str
    trusted: bool
    falls: bool = False
    structure: Number
    follows: str
    parameters: list[ParameterEntry]
    candidates: list[CandidateEntry]
    passes: list[PassEntry] = []
    by_slope: dict[str, Number] = {}
    apart_by_pendulum: tuple[Number, Number] | None = None

    @property
    def doubt(self) -> str:
        """The reason why a law is not trusted, in words."""
        if self.falls:
            return FASTER
        share = f"{100 * self.structure:.0f} % of what is left"
        return (
            f"{share} is no noise, but follows {NOTHING}"
            if self.follows == NOTHING
            else (f"{share} follows {self.follows}")
        )


class Report(Entry):
    """The whole report.

    ``effort_bandwidth`` (Hz, by joint) are those of drives found to low-pass their efforts.  ``not_simulated`` says why
    there is no ``simulation``.  If the log was ``refused`` as faulty, nothing was fitted.
    """

    schema_: Literal["mjfriction.report/1"] = Field(default=SCHEMA, alias="schema")
    verdict: Literal["explained", "consistent", "ambiguous", "unexplained", "bad_data"]
    summary: str
    joints: list[JointEntry]
    band_hz: Number | None = None
    findings: list[FindingEntry]
    next_experiment: str | None = None
    data_problems: list[DataProblem]
    adjustments: list[AdjustmentEntry] = []
    structure: list[StructureEntry] = []
    not_examined: list[str] = []
    identified: list[LawEntry] = []
    background: list[ParameterEntry] = []
    effort_bandwidth: dict[str, Number] = {}
    simulation: SimulationEntry | None = None
    not_simulated: str | None = None
    refused: bool = False
    made_by: dict[str, str] = {}

    model_config = ConfigDict(extra="forbid", frozen=True, populate_by_name=True)

    @property
    def driven(self) -> str:
        """The outcome of the free runs, in words, at the first finding's joint, or where the error fell most."""
        run = self.simulation
        if run is None or not run.joints:
            return f"Not driven in MuJoCo: {self.not_simulated}." if self.not_simulated else ""
        found = [entry.joint for entry in self.findings if entry.joint]
        most = max(run.joints, key=lambda drift: (drift.joint in found[:1], drift.rms_before - drift.rms_after))
        unit = f"m{most.unit}"
        return (
            f"Driven freely in MuJoCo by the log's efforts, {run.seconds:.2g} s at a time on motion not fitted, "
            f"{most.joint} ends up {1e3 * most.rms_before:.3g} {unit} off as stated and {1e3 * most.rms_after:.3g} "
            f"{unit} extended (RMS of {run.runs} runs)."
        )

    @property
    def low_passed(self) -> str:
        """A sentence on drives that low-pass the efforts they report; empty where none was found to."""
        if not self.effort_bandwidth:
            return ""
        listed = ", ".join(f"{joint} above {value:.3g} Hz" for joint, value in self.effort_bandwidth.items())
        return (
            f"The drives report their efforts low-passed: {listed}. robot.toml states it (effort_sensor.bandwidth), so "
            "that what it predicts is what they report."
        )


def make_report(diagnosis: Diagnosis) -> Report:
    """Return the report of a diagnosis."""
    return Report(
        verdict=diagnosis.verdict.value,
        summary=diagnosis.summary,
        band_hz=diagnosis.gap.chain.band,
        joints=[JointEntry(**vars(error)) for error in diagnosis.joints],
        findings=[_finding(finding) for finding in diagnosis.findings],
        next_experiment=diagnosis.next_experiment.words if diagnosis.next_experiment else None,
        data_problems=data_problems(diagnosis.gap, diagnosis.faults),
        adjustments=[
            AdjustmentEntry(
                what=entry.what,
                joint=entry.joint,
                unit=entry.unit,
                stated=entry.stated,
                fitted=entry.fitted,
                ci95=(entry.fitted - entry.half_width, entry.fitted + entry.half_width),
            )
            for entry in diagnosis.adjustments
        ],
        structure=_structure(diagnosis.structure_before, diagnosis.structure_after),
        not_examined=list(diagnosis.not_examined),
        effort_bandwidth=dict(diagnosis.bandwidths),
        simulation=_simulation(diagnosis),
        not_simulated=diagnosis.not_run,
        refused=diagnosis.refused,
        made_by=made_by(),
    )


def report_json(report: Report) -> str:
    """Return a report as JSON text, identical for equal reports."""
    return report.model_dump_json(by_alias=True, indent=2) + "\n"


def made_by() -> dict[str, str]:
    """Return the versions of the packages that a report was made with."""
    return {name: version(name) for name in ("mjfriction", "mujoco", "pin", "numpy", "scipy")}


def _finding(finding: Finding) -> FindingEntry:
    gain = finding.gain
    return FindingEntry(
        cause=finding.cause,
        joint=finding.joint,
        confidence=finding.confidence,
        alternatives=list(finding.alternatives),
        parameters=[parameter_entry(fitted) for fitted in finding.parameters],
        gain=GainEntry(
            rms_before=gain.before, rms_after=gain.after, reduction=gain.reduction, ci95=(gain.low, gain.high)
        ),
        evidence=finding.evidence,
    )


def parameter_entry(fitted: Fitted) -> ParameterEntry:
    """Return a fitted quantity as an entry of a report."""
    return ParameterEntry(
        name=fitted.name,
        value=fitted.value,
        unit=fitted.unit,
        ci95=(fitted.low, fitted.high),
        meaning=fitted.meaning,
        note=fitted.note,
    )


def _simulation(diagnosis: Diagnosis) -> SimulationEntry | None:
    run, gap = diagnosis.free_run, diagnosis.gap
    if run is None:
        return None
    drifts = [
        DriftEntry(
            joint=gap.robot.joints[joint],
            unit="m" if gap.body.sliding[joint] else "rad",
            rms_before=gain.before,
            rms_after=gain.after,
            reduction=gain.reduction,
            ci95=(gain.low, gain.high),
        )
        for joint, gain in run.gains.items()
    ]
    return SimulationEntry(seconds=run.seconds, runs=run.stated.shape[0], joints=drifts)


def _structure(before: tuple[Structure, ...], after: tuple[Structure, ...]) -> list[StructureEntry]:
    later = {(entry.joint, entry.covariate): entry.share for entry in after}
    return [
        StructureEntry(
            joint=entry.joint,
            covariate=entry.covariate,
            share_before=entry.share,
            share_after=later.get((entry.joint, entry.covariate), 0.0),
        )
        for entry in before
    ]


def data_problems(gap: Gap, faults: tuple[Fault, ...] = ()) -> list[DataProblem]:
    """Return the faults of a log: those found by the audit, those repaired on reading, gaps, and an uneven clock."""
    log, clock = gap.log, gap.motion.clock
    every = (*faults, *log.faults)
    problems = [DataProblem(kind=fault.kind, where=fault.where, action=fault.action) for fault in every]
    told = [span for fault in log.faults for span in fault.spans]
    problems += [
        DataProblem(
            kind="data.gap", where=f"{moment(log.time[row])} s to {moment(log.time[after])} s", action="split there"
        )
        for row, after in clock.gaps
        if not any(log.time[row] <= low and high <= log.time[after] for low, high in told)
    ]
    if clock.jitter > UNEVEN and any(grid.moved for grid in gap.motion.grids):
        problems.append(
            DataProblem(
                kind="data.clock",
                where=f"whole log: steps spread by {100 * clock.jitter:.2g} % around {clock.step:.4g} s",
                action="interpolated to an even clock",
            )
        )
    return problems
