"""report.html: one page that holds everything it shows and opens without a network."""

from __future__ import annotations

from pathlib import Path

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup
from plotly.offline import get_plotlyjs

from mjfriction.diagnose.outcome import Diagnosis
from mjfriction.report.figures import error_bars, figure_html, residual_against_covariate, time_course
from mjfriction.report.result import Report

MOST_COURSES = 3


def report_html(diagnosis: Diagnosis, report: Report) -> str:
    """Return the page of a diagnosis."""
    environment = Environment(
        loader=PackageLoader("mjfriction.report"), autoescape=True, undefined=StrictUndefined, trim_blocks=True
    )
    environment.filters["digits"] = lambda value: f"{value:.4g}"
    gap = diagnosis.gap
    findings = [
        (entry, Markup(figure_html(residual_against_covariate(diagnosis, finding), f"finding-{k}")))
        for k, (entry, finding) in enumerate(zip(report.findings, diagnosis.findings, strict=True))
    ]
    courses = [
        (joint, Markup(figure_html(time_course(diagnosis, joint), f"course-{k}")))
        for k, joint in enumerate(_joints_to_show(diagnosis))
    ]
    return environment.get_template("report.html.j2").render(
        report=report,
        robot=gap.robot.name,
        log_name=Path(gap.log.source).name,
        seconds=gap.motion.time.size / gap.motion.rate,
        rate=gap.motion.rate,
        band=gap.chain.band,
        bars=Markup(figure_html(error_bars(diagnosis), "errors")),
        findings=findings,
        courses=courses,
        plotly_script=Markup(get_plotlyjs()),
    )


def _joints_to_show(diagnosis: Diagnosis) -> list[str]:
    found = list(dict.fromkeys(finding.shown_at for finding in diagnosis.findings))
    by_error = sorted(diagnosis.joints, key=lambda error: -error.rms_heldout_before / max(error.noise_floor, 1e-300))
    return (found or [error.joint for error in by_error[:1]])[:MOST_COURSES]
