"""Results printed to a terminal, in 80 columns."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table
from rich.text import Text

from mjfriction.diagnose.causes.catalog import STRUCTURAL
from mjfriction.identify.comparison import Comparison
from mjfriction.record.fault import moment
from mjfriction.record.mapping import Mapping
from mjfriction.report.digits import digits
from mjfriction.report.result import FindingEntry, ParameterEntry, Report
from mjfriction.reproduce.outcome import Reproduction

WIDTH = 80
COLUMNS = 8  # places (the arm and its joints) that fit side by side in the table of causes
DITTO = "″"
HIDDEN = 0.3  # of a joint's RMS effort; a cause that must make more than this to be found is listed as not visible
COLOURS = {"explained": "green", "consistent": "green", "ambiguous": "yellow", "unexplained": "red", "bad_data": "red"}


def print_report(report: Report, console: Console) -> None:
    """Print verdict, joints and findings."""
    console.print(Text(report.verdict.upper(), style=f"bold {COLOURS[report.verdict]}"), Text(report.summary), sep="\n")
    if not report.refused:
        console.print()
        band = f", below {report.band_hz:.3g} Hz" if report.band_hz else ""
        console.print(Text(f"RMS error on motion not fitted{band}", style="italic"))
        console.print(_joint_table(report))
        if report.driven:
            console.print(f"\n{report.driven}")
    for finding in report.findings:
        console.print()
        _print_finding(finding, console)
    if report.verdict != "bad_data" or len(report.data_problems) > 1:  # the summary states a single one already
        _print_problems(report, console)
    moved = [entry for entry in report.adjustments if abs(entry.fitted - entry.stated) > 0.01 * abs(entry.stated)]
    if moved:
        values = ", ".join(f"{e.what} of {e.joint} {e.stated:.3g} → {e.fitted:.3g}" for e in moved)
        console.print(f"\nRefitted along, and written to the extended robot: {values}")
    if report.not_examined:
        console.print(f"\nNot examined (hardly any motion, or no usable measurement): {', '.join(report.not_examined)}")


def print_reproduced(found: Sequence[Reproduction], console: Console) -> None:
    """Print which claims of the source documents the reproduced experiments confirm, and which they do not."""
    for k, one in enumerate(found):
        if k:
            console.print()
        console.print(Text(one.title, style="bold"))
        for claim in one.claims:
            mark, colour = ("holds ", "green") if claim.holds else ("not so", "red")
            lines = textwrap.wrap(claim.sentence, WIDTH - 8) + textwrap.wrap(claim.figures, WIDTH - 10)
            console.print(Text(mark, style=colour), Text(lines[0]), sep="  ")
            for line in lines[1:]:
                console.print(f"        {line}")


def print_identified(report: Report, console: Console) -> None:
    """Print the identified laws of all joints."""
    trusted = report.verdict != "unexplained"
    head = Text("IDENTIFIED", style="bold green") if trusted else Text("IDENTIFIED, NOT EXPLAINED", style="bold red")
    console.print(head, Text(report.summary), sep="\n")
    console.print()
    band = f", below {report.band_hz:.3g} Hz" if report.band_hz else ""
    console.print(Text(f"RMS error on motion not fitted{band}", style="italic"))
    console.print(_joint_table(report))
    for law in report.identified:
        side = ", motor side" if law.side == "motor" else ""
        console.print()
        console.print(Text(f"{law.joint}: {law.law}", style="bold"), Text(f"(from {law.how}{side})"))
        for parameter in law.parameters:
            _print_parameter(parameter, console)
        if not law.trusted:
            console.print(f"  {law.doubt}" + ("" if law.falls else ": the law does not hold here"))
    _print_problems(report, console)
    if report.not_examined:
        console.print(f"\nNot examined (hardly any motion, or no usable measurement): {', '.join(report.not_examined)}")


def _print_problems(report: Report, console: Console) -> None:
    if report.low_passed:
        console.print(f"\n{report.low_passed}")
    if report.data_problems:
        console.print("\nThe log:")
    for problem in report.data_problems:
        console.print(f"  {problem.kind}: {problem.where}; {problem.action}")


def _print_parameter(parameter: ParameterEntry, console: Console) -> None:
    low, high = parameter.ci95
    unit = "" if parameter.unit == "1" else f" {parameter.unit}"
    note = f"; {parameter.note}" if parameter.note else ""
    value, least, most = (digits(own, parameter.unit) for own in (parameter.value, low, high))
    console.print(f"  {parameter.name} = {value}{unit}  (95 %: {least} to {most}{note})")


def _joint_table(report: Report) -> Table:
    table = Table(box=None, padding=(0, 2, 0, 0))
    table.add_column("joint", overflow="fold")
    for name in ("before", "after", "sensor noise"):
        table.add_column(name, justify="right")
    table.add_column("unit")
    for joint in report.joints:
        table.add_row(
            joint.joint,
            f"{joint.rms_heldout_before:.3g}",
            f"{joint.rms_heldout_after:.3g}",
            f"{joint.noise_floor:.2g}",
            joint.unit,
        )
    return table


def _print_finding(finding: FindingEntry, console: Console) -> None:
    place = f" at {finding.joint}" if finding.joint else ""
    console.print(Text(f"{finding.cause}{place}", style="bold"), Text(f"(confidence {finding.confidence:.2f})"))
    console.print(f"  {finding.evidence}")
    for parameter in finding.parameters:
        _print_parameter(parameter, console)
    if finding.alternatives:
        console.print(f"  cannot be told on this motion from: {', '.join(finding.alternatives)}")


def print_comparison(comparison: Comparison, console: Console) -> None:
    """Print which robot is nearest, and a table of errors.

    Each joint has a row in torque, one in current where all robots can predict it, and one in position where the robots
    were simulated.
    """
    console.print(f"{comparison.summary}\n")
    console.print(f"RMS error while the joint moves, below {comparison.gap.chain.band:.3g} Hz", style="italic")
    table = Table(box=None, padding=(0, 2, 0, 0))
    table.add_column("joint", overflow="fold")
    for name in comparison.names:
        table.add_column(name, justify="right", overflow="fold")
    table.add_column("sensor noise", justify="right")
    table.add_column("unit")
    for joint in comparison.joints:
        efforts = [f"{error.effort:.3g}" for error in joint.errors]
        table.add_row(joint.joint, *efforts, f"{joint.noise_floor:.2g}", joint.unit)
        currents = [error.current for error in joint.errors]
        if all(current is not None for current in currents):
            table.add_row("  in current", *(f"{current:.3g}" for current in currents), "", "A")
        if comparison.seconds is not None:
            ends = [f"{error.position:.3g}" for error in joint.errors]
            table.add_row("  in position", *ends, "", joint.position_unit)
    console.print(table)
    if comparison.seconds is not None:
        console.print(
            f"in position: how far off (RMS) when driven by the log's efforts, {comparison.seconds:.3g} s at a time",
            style="italic",
        )


def print_mapping(guess: Mapping, log: Path, written: Path | None, console: Console) -> None:
    """Print the guessed mapping of a file's columns, and how to accept it."""
    console.print(f"The columns of {log} have other names. They look like this:", style="bold", markup=False)
    for own, source in guess.sources.items():
        scaled = "" if source.scale == 1.0 else f" times {source.scale:.6g}"
        console.print(f"  {own}  from '{source.column}'{scaled}", markup=False)
    kept = f"--map {written}" if written is not None else "--map guess"
    console.print(f"If that is right, add {kept} to the command; below, the log is read so.\n", markup=False)


def print_unguessed(names: Sequence[str], log: Path, written: Path, console: Console) -> None:
    """Print that a file's columns could not be guessed, and where the mapping file to fill in is."""
    told = f"{', '.join(names[:6])}{', …' * (len(names) > 6)}"
    console.print(f"The names of the columns of {log} tell too little ({told}).", markup=False)
    console.print(f"{written} has a line for each that is needed: fill it in, and give it with --map.", markup=False)


def print_inspected(told: dict[str, Any], console: Console) -> None:
    """Print what a log contains, and what it could show."""
    segments = f", {told['segments']} segments" if told["segments"] > 1 else ""
    jitter = f", steps uneven by {100 * told['jitter']:.2g} %" if told["jitter"] > 1e-3 else ""
    console.print(told["log"], soft_wrap=True, markup=False)
    console.print(f"{told['rows']} rows, {told['seconds']:.4g} s at {told['rate']:.4g} Hz{jitter}{segments}")
    for begin, end in told["gaps"]:
        console.print(f"  a gap from {moment(begin)} to {moment(end)} s")
    for problem in told["data_problems"]:
        console.print(f"  {problem['kind']}: {problem['where']}; {problem['action']}")
    table = Table(box=None, padding=(0, 2, 0, 0))
    table.add_column("")
    table.add_column("joint", overflow="fold")
    for head in ("from", "to", "top speed", "reversals", "RMS"):
        table.add_column(head, justify="right")
    table.add_column("")
    for number, joint in enumerate(told["joints"], start=1):
        numbers = [f"{value:.3g}" for value in (*joint["range"], joint["top_speed"])]
        rms = f"{joint['rms']:.3g}" if "rms" in joint else "not measured"
        table.add_row(str(number), joint["joint"], *numbers, str(joint["reversals"]), rms, joint.get("unit", ""))
    console.print(table)
    if told["other_columns"]:
        console.print(f"Besides: {', '.join(told['other_columns'])}")
    if "could_show" not in told:
        console.print("\nWith --robot R this also says what the log could show.")
        return
    if told["could_show"]:
        _print_visible(told, console)
    else:
        console.print("\nWhat it could show is told once the log reads right.")


def _print_visible(told: dict[str, Any], console: Console) -> None:
    console.print(
        "\nWhat it could show: the effect, in % of the joint's RMS effort, from which on a cause is found; joints by "
        "their numbers above, with what concerns the whole arm first. "
        f"Where a cell is empty it would take more than {100 * HIDDEN:.0f} %, or the motion cannot show it; "
        f"{DITTO} is as above"
    )
    places = [None, *(joint["joint"] for joint in told["joints"])]
    least = {(one["cause"], one["joint"]): one["share"] for one in told["could_show"] if one["share"] < HIDDEN}
    causes = list(dict.fromkeys(cause.name for cause in STRUCTURAL))
    for first in range(0, len(places), COLUMNS):
        own = places[first : first + COLUMNS]
        table = Table(box=None, padding=(0, 1, 0, 0))
        table.add_column("")
        for place in own:
            table.add_column("arm" if place is None else str(places.index(place)), justify="right", min_width=5)
        above = [""] * len(own)
        for cause in causes:
            shares = [least.get((cause, place)) for place in own]
            cells = ["" if share is None else f"{100 * share:.2g}" for share in shares]
            if any(cells):
                table.add_row(
                    cause, *(DITTO if cell and cell == last else cell for cell, last in zip(cells, above, strict=True))
                )
                above = cells
        console.print(table)
    hidden = [cause for cause in causes if cause not in {name for name, _ in least}]
    if hidden:
        console.print(f"Not on this motion, or for want of a column: {', '.join(hidden)}")
