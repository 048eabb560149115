"""report.json of an identification: its machine-readable form."""

from __future__ import annotations

from mjfriction.identify.outcome import Identification, JointLaw
from mjfriction.report.result import (
    CandidateEntry,
    JointEntry,
    LawEntry,
    PassEntry,
    Report,
    data_problems,
    made_by,
    parameter_entry,
)


def make_identified_report(identification: Identification) -> Report:
    """Return the report of an identification; its verdict is ``unexplained`` unless all laws are trusted."""
    gap = identification.gap
    named = {law.joint for law in identification.laws}
    return Report(
        verdict="explained" if all(law.trusted for law in identification.laws) else "unexplained",
        summary=identification.summary,
        band_hz=gap.chain.band,
        joints=[JointEntry(**vars(error)) for error in identification.joints],
        findings=[],
        data_problems=data_problems(gap),
        not_examined=[joint for joint in gap.robot.joints if joint not in named],
        identified=[_law(law) for law in identification.laws],
        effort_bandwidth=dict(identification.bandwidths),
        background=[parameter_entry(fitted) for fitted in identification.background],
        made_by=made_by(),
    )


def _law(law: JointLaw) -> LawEntry:
    apart = None
    if law.pendulum is not None:
        stated, fitted = law.pendulum.apart.tolist()
        apart = (stated, fitted)
    passes = []
    if law.passes is not None:
        points = zip(law.passes.speed, law.passes.friction, law.passes.spread, strict=True)
        passes = [PassEntry(speed=v, friction=f, spread=s) for v, f, s in points]
    return LawEntry(
        joint=law.joint,
        law=law.fit.law.name,
        side=law.fit.problem.side,
        how=law.how,
        trusted=law.trusted,
        falls=law.falls,
        structure=law.structure,
        follows=law.follows,
        parameters=[parameter_entry(fitted) for fitted in law.parameters],
        candidates=[CandidateEntry(**vars(candidate)) for candidate in law.candidates],
        passes=passes,
        apart_by_pendulum=apart,
        by_slope=law.by_slope.values if law.by_slope is not None else {},
    )
