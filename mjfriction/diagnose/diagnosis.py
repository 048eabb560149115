"""A whole diagnosis: a log and a robot in; findings, the extended robot and the proof out."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace

import numpy as np

from mjfriction.diagnose.causes.catalog import STRUCTURAL
from mjfriction.diagnose.faults.mend import audited
from mjfriction.diagnose.fit.exact import usual_nuisance
from mjfriction.diagnose.fit.extend import adjustments, extend_robot
from mjfriction.diagnose.fit.model import Model
from mjfriction.diagnose.fit.nuisance import Nuisance
from mjfriction.diagnose.search.field import Field, make_field
from mjfriction.diagnose.search.fitted_on import fitted_on
from mjfriction.diagnose.search.second_look import compete_twice
from mjfriction.diagnose.search.unevenness import as_uneven, with_unevenness
from mjfriction.diagnose.settle.stated import Settled, settle
from mjfriction.diagnose.tell.findings import make_findings
from mjfriction.diagnose.tell.free_run import FreeRun, run_freely
from mjfriction.diagnose.tell.needless import spared
from mjfriction.diagnose.tell.outcome import Diagnosis, Verdict
from mjfriction.diagnose.tell.seen_play import play_findings, see_play, unseen
from mjfriction.diagnose.tell.verdict import reach_verdict, summarize, with_faults
from mjfriction.diagnose.tell.what_gives import asked_of, doubt, gives_more, left_in_blows
from mjfriction.errors import InputError
from mjfriction.identify.effort_bandwidth import find_bandwidths, with_bandwidths
from mjfriction.identify.excerpt import excerpt
from mjfriction.identify.gap import Gap
from mjfriction.identify.joint_error import joint_error
from mjfriction.identify.structure import find_structure
from mjfriction.progress import Tell, silently
from mjfriction.record.log import Log
from mjfriction.robot.robot import Robot

HIGHEST = 60.0  # Hz, highest cutoff of the position filter: above it arms mostly bend, which no cause describes
# Shares of the work that are done before the second search, before the proof, and before the free run.
SEARCHING_AGAIN, PROVING, DRIVING = 0.8, 0.85, 0.95


def diagnose_log(log: Log, robot: Robot, *, seed: int = 0, tell: Tell = silently) -> Diagnosis:
    """Compare a log with a robot and report what the robot gets wrong.

    ``seed`` sets the resampling behind the intervals of the gains; ``tell`` is called at each step. Raises
    :class:`~mjfriction.errors.LogError` or :class:`~mjfriction.errors.RobotError` when either cannot be used.
    """
    tell("measuring the gap", 0.0)
    audit = audited(log, robot, highest=HIGHEST)
    refused = audit.refused
    seen = unseen(audit.gap) if refused else see_play(audit.gap, HIGHEST)
    field = make_field(excerpt(seen.gap), () if refused else STRUCTURAL)
    settled = _searched(seen.gap, field, tell)
    doubted = None if refused else doubt(seen, settled.model, HIGHEST)
    if doubted is not None:
        tell("searching for what gives", SEARCHING_AGAIN)
        anew = make_field(excerpt(doubted.seen.gap), STRUCTURAL) if doubted.loud else field
        again = _searched(doubted.seen.gap, asked_of(doubted, anew, settled.model), silently)
        if gives_more(doubted, again.model, settled.model):
            settled, field, seen, doubted = again, anew, doubted.seen, None
    tell("proving what was found", PROVING)
    settled, over = spared(settled)
    model, gap = settled.model, settled.model.gap
    left, heldout, untold = model.residual(oscillations=True, built=True), over.heldout, over.untold
    remaining = (*over.remaining, *(() if doubted is None else left_in_blows(doubted, model)))
    told = make_findings(settled, untold, field, seed)
    findings = sorted((*play_findings(seen, heldout, seed), *told.findings), key=lambda one: -one.gain.reduction)
    joints = tuple(joint_error(gap, joint, left, heldout, seed, stated=seen.stated) for joint in gap.examined)
    extended = extend_robot(model)
    bandwidths = {} if refused else find_bandwidths(seen.whole, extended)
    driven, not_run = (None, None) if refused else _driven(model, robot, seed, seen.jumps.keys(), tell)
    verdict = reach_verdict(findings, remaining)
    summary = "" if refused else summarize(gap, verdict, findings, joints, remaining)
    return Diagnosis(
        gap=gap,
        verdict=Verdict.BAD_DATA if audit.faults else verdict,
        summary=with_faults(summary, audit),
        joints=joints,
        findings=tuple(findings),
        adjustments=tuple(adjustments(model, told.untold)),
        structure_before=tuple(find_structure(gap, np.nan_to_num(seen.stated))),
        structure_after=over.structure,
        remaining=remaining,
        faults=(*audit.faults, *audit.unused),
        refused=refused,
        not_examined=tuple(joint for i, joint in enumerate(gap.robot.joints) if i not in gap.examined),
        robot=with_bandwidths(extended, bandwidths),
        bandwidths=bandwidths,
        next_experiment=None if audit.moved_otherwise else told.experiment,
        residual_after=left,
        heldout=heldout,
        free_run=driven,
        not_run=not_run,
    )


def _searched(gap: Gap, field: Field, tell: Tell) -> Settled:
    # What a search of a field finds; a log of which nothing is asked was refused.
    part = excerpt(gap)
    nuisance = with_unevenness(part, usual_nuisance(part)) if field else Nuisance((), (), ())
    found, asked = compete_twice(part, nuisance, field, tell)
    settled = settle(as_uneven(found), asked)
    return replace(settled, model=fitted_on(gap, settled.model))


def _driven(
    model: Model, stated: Robot, seed: int, jumping: Collection[int], tell: Tell
) -> tuple[FreeRun | None, str | None]:
    tell("driving both robots freely", DRIVING)
    try:
        return run_freely(model, stated, seed, jumping), None
    except InputError as error:
        return None, str(error)  # a robot that MuJoCo cannot hold is diagnosed all the same
