"""comparison.json, report.html and recording.rrd of several robots compared with one log."""

from __future__ import annotations

import json
from pathlib import Path

from markupsafe import Markup

from mjfriction.identify.comparison import Comparison
from mjfriction.report.digits import kept
from mjfriction.report.figures import bars, courses, figure_html
from mjfriction.report.html import rendered
from mjfriction.report.rerun_view import write_compared_recording


def comparison_table(comparison: Comparison) -> dict[str, object]:
    """Return a comparison as plain data, numbers to seven digits."""

    def number(value: float | None) -> float | None:
        return None if value is None else kept(value)

    return {
        "log": comparison.gap.log.name,
        "robots": list(comparison.names),
        "best": comparison.best,
        "simulated_seconds": number(comparison.seconds),
        "joints": [
            {
                "joint": joint.joint,
                "unit": joint.unit,
                "rms_measured": number(joint.measured),
                "noise_floor": number(joint.noise_floor),
                "rms_effort": [number(error.effort) for error in joint.errors],
                "rms_current": [number(error.current) for error in joint.errors],
                "share": [number(error.share) for error in joint.errors],
                "rms_position": [number(error.position) for error in joint.errors],
            }
            for joint in comparison.joints
        ],
    }


def write_comparison(comparison: Comparison, folder: Path) -> None:
    """Write comparison.json, report.html and recording.rrd."""
    gap = comparison.gap
    table = json.dumps(comparison_table(comparison), indent=2, ensure_ascii=False) + "\n"
    (folder / "comparison.json").write_text(table, encoding="utf-8")
    named = [joint.joint for joint in comparison.joints]
    errors = {name: [joint.errors[k].effort for joint in comparison.joints] for k, name in enumerate(comparison.names)}
    units = " and ".join(sorted({joint.unit for joint in comparison.joints}))
    picture = bars(named, errors, [joint.noise_floor for joint in comparison.joints], units)
    pictures = []
    for k, joint in enumerate(comparison.joints):
        place = gap.robot.joints.index(joint.joint)
        own = {name: one.residual[:, place] for name, one in zip(comparison.names, comparison.gaps, strict=True)}
        figure = courses(gap.chain.time, gap.measured[:, place], own, joint.unit, gap.clear[:, place])
        pictures.append((joint.joint, Markup(figure_html(figure, f"course-{k}"))))
    page = rendered(
        "comparison.html.j2",
        log_name=gap.log.name,
        names=comparison.names,
        summary=comparison.summary,
        joints=comparison.joints,
        seconds=comparison.seconds,
        band=gap.chain.band,
        bars=Markup(figure_html(picture, "errors")),
        courses=pictures,
    )
    (folder / "report.html").write_text(page, encoding="utf-8")
    write_compared_recording(comparison, folder / "recording.rrd")
