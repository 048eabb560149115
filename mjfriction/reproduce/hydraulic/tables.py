"""The cylinder's numbers beside those that the hydraulic document prints."""

from __future__ import annotations

import numpy as np

from mjfriction.control.valve import ValveGains
from mjfriction.reproduce.hydraulic.experiments import LAW, Compared
from mjfriction.reproduce.hydraulic.identified import (
    MOST_FAST,
    Identified,
    fast_voltage,
)
from mjfriction.reproduce.outcome import Row, Table

PRINTED_RMS = {1: (189.0, 304.0), 2: (9.12, 11.0), 3: (9.62, 11.8), 4: (102.6, 151.0)}
PRINTED_BETTER = (1.6, 2.2)


def variants(identified: Identified) -> Table:
    """Return the error of every friction model at constant speed."""
    rows = []
    for number in (1, 2, 3, 4, 5):
        own = [identified.tried[way][number] for way in ("extending", "retracting")]
        printed = PRINTED_RMS.get(number, (None, None))
        rows.append(
            Row(
                f"model {number}" if number < 5 else "x₁, x₄, x₅ (ours)",
                (round(own[0].rms, 4), round(own[1].rms, 4), *printed, own[0].criterion, own[1].criterion),
            )
        )
    return Table(
        "Table 1: models of friction at constant speed",
        (
            "RMS N, extending",
            "retracting",
            "printed, extending",
            "printed, retracting",
            "criterion, extending",
            "retracting ",
        ),
        tuple(rows),
        "Model 1 drops x₄, 3 drops x₂, 4 drops x₂, x₃ and x₄. The criterion is χ² + k·ln n; less is better.",
    )


def tracking_errors(compared: dict[str, Compared]) -> Table:
    """Return the errors along the reference, every compensation beside PD."""
    pd = compared["PD"].runs["nominal"]
    rows = []
    for name, own in compared.items():
        run = own.runs["nominal"]
        better = [pd.rms(extending=way) / run.rms(extending=way) for way in (True, False)]
        printed = (None, None) if name == "PD" else PRINTED_BETTER
        rows.append(
            Row(name, (run.rms(extending=True), run.rms(extending=False), *better, *printed, fast_voltage(run)))
        )
    columns = (
        "RMS mm, extending",
        "retracting",
        "times better than PD, extending",
        "retracting ",
        "printed: at least, extending",
        "printed: at least, retracting",
        "voltage above 20 Hz, V",
    )
    return Table(
        "Tracking error, the same gains in both directions",
        columns,
        tuple(rows),
        "Every controller's two gains were found by one procedure: the least error, weighed up by as much as its "
        f"voltage above 20 Hz passes {MOST_FAST:g} V.",
    )


def estimation_errors(compared: dict[str, Compared]) -> Table:
    """Return the error of the friction that the controllers used, against the true friction."""
    rows = []
    law = compared[LAW].runs["nominal"].rms()
    for name, own in compared.items():
        if name == "PD":
            continue
        run = own.runs["nominal"]
        error = float(np.sqrt(np.mean(np.square(run.estimated - run.true))))
        rows.append(Row(name, (error, 100.0 * error / float(np.sqrt(np.mean(np.square(run.true)))), run.rms() / law)))
    sharp, smooth = (compared["variable structure"].runs[name] for name in ("sharp", "nominal"))
    return Table(
        "Friction as it was estimated while the controllers ran (figure 7)",
        ("RMS N from the true friction", "% of it", "tracking error over the law's"),
        tuple(rows),
        f"The variable-structure observer asks the valve for {fast_voltage(smooth):.3g} V above 20 Hz with the smooth "
        f"switching of (14), for {fast_voltage(sharp):.3g} V with the signum of (13).",
    )


def robustness(compared: dict[str, Compared]) -> Table:
    """Return how the errors grow with another supply and another load."""
    rows = []
    for name, own in compared.items():
        cells = [own.runs[case].rms() for case in ("nominal", "20 bar", "96 kg")]
        rows.append(Row(name, (*cells, cells[1] / cells[0], cells[2] / cells[0], fast_voltage(own.runs["96 kg"]))))
    return Table(
        "Supply 80 to 20 bar, load 6 to 96 kg, gains and observers as before (figure 9)",
        ("RMS mm", "at 20 bar", "with 96 kg", "20 bar, times", "96 kg, times", "96 kg: voltage above 20 Hz, V"),
        tuple(rows),
        "A voltage of several volts above 20 Hz is a limit cycle of the valve: the gains are too high for that load.",
    )


def gains_found(compared: dict[str, Compared], separate: tuple[ValveGains, ValveGains]) -> Table:
    """Return the gains of all controllers."""
    rows = [
        Row(name, (own.gains.position, own.gains.velocity, own.gains.acceleration)) for name, own in compared.items()
    ]
    for way, own in zip(("extending", "retracting"), separate, strict=True):
        rows.append(Row(f"variable structure, {way} alone", (own.position, own.velocity, own.acceleration)))
    return Table("Gains", ("K_p, V/m", "K_v, V·s/m", "K_a, V·s²/m"), tuple(rows))
