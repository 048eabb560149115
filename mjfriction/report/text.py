"""Results in a terminal, in 80 columns."""

from __future__ import annotations

from rich.console import Console
from rich.table import Table
from rich.text import Text

from mjfriction.identify.comparison import Comparison
from mjfriction.report.result import FindingEntry, ParameterEntry, Report

WIDTH = 80
COLOURS = {"explained": "green", "consistent": "green", "ambiguous": "yellow", "unexplained": "red", "bad_data": "red"}


def print_report(report: Report, console: Console) -> None:
    """Print verdict, joints and findings."""
    console.print(Text(report.verdict.upper(), style=f"bold {COLOURS[report.verdict]}"), Text(report.summary), sep="\n")
    console.print()
    band = f", below {report.band_hz:.3g} Hz" if report.band_hz else ""
    console.print(Text(f"RMS error on motion not fitted{band}", style="italic"))
    console.print(_joint_table(report))
    for finding in report.findings:
        console.print()
        _print_finding(finding, console)
    for problem in report.data_problems:
        console.print(f"\n{problem.kind}: {problem.where}; {problem.action}")
    moved = [entry for entry in report.adjustments if abs(entry.fitted - entry.stated) > 0.01 * abs(entry.stated)]
    if moved:
        values = ", ".join(f"{e.what} of {e.joint} {e.stated:.3g} → {e.fitted:.3g}" for e in moved)
        console.print(f"\nRefitted along, and written to the extended robot: {values}")
    if report.not_examined:
        console.print(f"\nNot examined (no motion or no measurement): {', '.join(report.not_examined)}")


def print_identified(report: Report, console: Console) -> None:
    """Print the laws of an identification."""
    console.print(Text("IDENTIFIED", style="bold green"), Text(report.summary), sep="\n")
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
            share = f"{100 * law.structure:.0f} % of what is left follows {law.follows}"
            console.print(f"  {share}: the law does not hold here")
    for problem in report.data_problems:
        console.print(f"\n{problem.kind}: {problem.where}; {problem.action}")
    if report.not_examined:
        console.print(f"\nNot examined (no motion or no measurement): {', '.join(report.not_examined)}")


def _print_parameter(parameter: ParameterEntry, console: Console) -> None:
    low, high = parameter.ci95
    unit = "" if parameter.unit == "1" else f" {parameter.unit}"
    note = f"; {parameter.note}" if parameter.note else ""
    console.print(f"  {parameter.name} = {parameter.value:.4g}{unit}  (95 %: {low:.4g} to {high:.4g}{note})")


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
    """Print who is nearest, and a table: one row a joint in torque, one in current where all robots can tell."""
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
            table.add_row("", *(f"{current:.3g}" for current in currents), "", "A")
    console.print(table)
