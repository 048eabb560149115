"""report.html: a self-contained page that opens without a network."""

from __future__ import annotations

from collections.abc import Sequence

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup
from plotly.offline import get_plotlyjs

from mjfriction.diagnose.tell.outcome import Diagnosis
from mjfriction.identify.outcome import Identification
from mjfriction.identify.structure import COVARIATES
from mjfriction.report.compared import Compared
from mjfriction.report.digits import digits, percentage
from mjfriction.report.figures import error_bars, figure_html, time_course
from mjfriction.report.finding_figure import finding_figure
from mjfriction.report.free_run_figure import free_run_figure
from mjfriction.report.law_figure import friction_against_speed
from mjfriction.report.result import Report

MOST_COURSES = 3


def report_html(diagnosis: Diagnosis, report: Report) -> str:
    """Return the page of a diagnosis."""
    findings = [
        (entry, Markup(figure_html(finding_figure(diagnosis, finding), f"finding-{k}")))
        for k, (entry, finding) in enumerate(zip(report.findings, diagnosis.findings, strict=True))
    ]
    found = list(dict.fromkeys(finding.shown_at for finding in diagnosis.findings))
    words = {"badge": report.verdict, "after": "extended", "verb": "diagnose"}
    more: dict[str, object] = {**words, "findings": findings, "followed": _followed(report), "covariates": COVARIATES}
    more["driven"] = _driven(diagnosis, _joints_to_show(diagnosis, found))
    return _page("report.html.j2", diagnosis, report, found, more)


def _driven(diagnosis: Diagnosis, joints: Sequence[str]) -> list[tuple[str, Markup]]:
    run, gap = diagnosis.free_run, diagnosis.gap
    if run is None:
        return []
    shown = [(joint, place) for joint in joints if (place := gap.robot.joints.index(joint)) in run.gains]
    return [
        (joint, Markup(figure_html(free_run_figure(run, place, sliding=gap.body.sliding[place]), f"driven-{k}")))
        for k, (joint, place) in enumerate(shown)
    ]


def _followed(report: Report) -> list[tuple[str, list[tuple[float, float]]]]:
    # By joint, the shares before and after for every covariate; 0 for one that the motion does not vary.
    shares = {(entry.joint, entry.covariate): (entry.share_before, entry.share_after) for entry in report.structure}
    joints = dict.fromkeys(entry.joint for entry in report.structure)
    return [(joint, [shares.get((joint, covariate), (0.0, 0.0)) for covariate in COVARIATES]) for joint in joints]


def identified_html(identification: Identification, report: Report) -> str:
    """Return the page of an identification."""
    laws = [
        (entry, Markup(figure_html(friction_against_speed(identification, law), f"law-{k}")))
        for k, (entry, law) in enumerate(zip(report.identified, identification.laws, strict=True))
    ]
    badge = "identified" if report.verdict != "unexplained" else "identified, not explained"
    words = {"badge": badge, "after": "identified", "verb": "identify"}
    return _page("identified.html.j2", identification, report, [], {**words, "laws": laws})


def _page(template: str, compared: Compared, report: Report, first: Sequence[str], more: dict[str, object]) -> str:
    gap = compared.gap
    courses = [
        (joint, Markup(figure_html(time_course(compared, joint, str(more["after"])), f"course-{k}")))
        for k, joint in enumerate(_joints_to_show(compared, first))
    ]
    return rendered(
        template,
        report=report,
        robot=gap.robot.name,
        log_name=gap.log.name,
        seconds=gap.motion.time.size / gap.motion.rate,
        rate=1.0 / gap.motion.clock.step,
        band=gap.chain.band,
        bars=Markup(figure_html(error_bars(compared, str(more["after"])), "errors")),
        courses=courses,
        **more,
    )


def rendered(template: str, **values: object) -> str:
    """Return a page: a template filled with values and the plotting script."""
    environment = Environment(
        loader=PackageLoader("mjfriction.report"), autoescape=True, undefined=StrictUndefined, trim_blocks=True
    )
    environment.filters["digits"] = digits
    environment.filters["percentage"] = percentage
    environment.filters["percent"] = lambda value: f"{percentage(max(value, 0.0))} %"
    return environment.get_template(template).render(plotly_script=Markup(get_plotlyjs()), **values)


def _joints_to_show(compared: Compared, first: Sequence[str]) -> list[str]:
    by_error = sorted(compared.joints, key=lambda error: -error.rms_heldout_before / max(error.noise_floor, 1e-300))
    return (list(first) or [error.joint for error in by_error[:1]])[:MOST_COURSES]
