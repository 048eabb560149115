"""The table's numbers beside those that the pre-sliding document prints."""

from __future__ import annotations

import numpy as np

from mjfriction.laws.rules import array
from mjfriction.reproduce.outcome import Row, Table
from mjfriction.reproduce.table.experiments import Tracked
from mjfriction.reproduce.table.identified import (
    PRINTED_SHAPE,
    Identified,
    following_errors,
)
from mjfriction.reproduce.table.machine import (
    JOINT,
    OBSERVER,
    WEAK,
    true_table,
)

PRINTED = {
    "PD": 46.2,
    "observer": 9.7,
    "observer and dahl": 6.6,
    "observer and lugre": 7.6,
    "observer and leuven over position": 6.1,
    "observer and gms": 2.6,
}
"""Peak-to-peak errors of the document, µm."""


def tracking_errors(runs: dict[str, Tracked]) -> Table:
    """Return the errors along the reference, every compensation beside the document's."""
    rows = []
    for name, tracked in runs.items():
        printed = PRINTED.get(name)
        rows.append(
            Row(
                name,
                (
                    tracked.peak_to_peak,
                    tracked.rms,
                    runs["PD"].peak_to_peak / tracked.peak_to_peak,
                    printed,
                    None if printed is None else PRINTED["PD"] / printed,
                ),
            )
        )
    columns = ("peak to peak, µm", "RMS, µm", "times better than PD", "printed, µm", "printed, times better")
    return Table(
        "Position error along the reference",
        columns,
        tuple(rows),
        "The last of two periods. PD and observer are as weak as the document's: a PD of "
        f"{WEAK:g} Hz, an observer of {OBSERVER:g} Hz, chosen once for PD's error and the observer's to be of the "
        "document's size. Everything else comes out.",
    )


def parameters_found(identified: Identified) -> Table:
    """Return the identified parameters beside the true and the printed ones."""
    curve, dahl, gms = identified.stribeck.values, identified.laws["dahl"], identified.laws["gms"]
    truth = (true_table().joint(JOINT).friction or ())[0]

    def true(name: str) -> float:
        return float(truth.value(name))

    found, there = array(gms.parameters, "stiffness"), array(truth.parameters, "stiffness")
    rows = [
        Row("F_s, N", (curve["static"], true("static"), 54.0)),
        Row("F_c, N", (curve["coulomb"], true("coulomb"), 39.2)),
        Row("V_s, µm/s", (1e6 * curve["stribeck_velocity"], 1e6 * true("stribeck_velocity"), 698.0)),
        Row("δ_Vs", (curve["stribeck_exponent"], true("stribeck_exponent"), 0.98)),
        Row("σ₂, N·s/µm", (1e-6 * curve["viscous"], 1e-6 * true("viscous"), 8.4e-5)),
        Row("elements", (float(len(found)), float(len(there)), 12.0)),
        Row(
            "stiffness at rest, N/µm",
            (1e-6 * float(np.sum(found)), 1e-6 * float(np.sum(there)), None),
        ),
        Row("Dahl σ₀, N/µm", (1e-6 * dahl.value("bristle_stiffness"), None, 1.4)),
        Row("Dahl δ_d", (dahl.value("shape_exponent"), None, 5.14)),
        Row("LuGre σ₁, N·s/µm", (1e-6 * identified.laws["lugre"].value("bristle_damping"), None, 0.01)),
        Row("GMS C, N/s", (gms.value("attraction"), true("attraction"), 65.0)),
        Row("Leuven exponent", (identified.laws["leuven"].value("shape_exponent"), None, PRINTED_SHAPE)),
    ]
    return Table(
        "Parameters identified from the table's own experiments", ("identified", "true", "printed"), tuple(rows)
    )


def loops_left(identified: Identified) -> Table:
    """Return every law's error on the slow turns, and the held-out error of every number of elements."""
    errors = following_errors(identified)
    rows = [Row(law, (error, 100.0 * error / identified.stribeck.values["static"])) for law, error in errors.items()]
    counts = [
        Row(f"{count} elements", (error, 100.0 * error / identified.stribeck.values["static"]))
        for count, error in identified.elements.heldout.items()
    ]
    return Table(
        "What the laws leave of slow turns (figure 4B), and elements over turns that were not fitted",
        ("RMS, N", "% of F_s"),
        (*rows, *counts),
    )


def numbers_stored(identified: Identified) -> Table:
    """Return how many numbers every law stores."""
    rows = []
    for name, term in identified.laws.items():
        packed = term.friction(1.0)
        rows.append(Row(name, (float(packed.values.size), float(packed.state_count))))
    return Table(
        "Table I: numbers that each law keeps",
        ("parameters", "state"),
        tuple(rows),
        "Operations and time of one evaluation, counted and measured, stand in docs/benchmarks.md.",
    )
