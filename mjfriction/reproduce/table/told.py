"""``reproduce table``: pre-sliding compensation on the machine-tool table, by feedforward, by an observer, by both.

Lampaert, Swevers, Al-Bender and others, "Comparison of model and non-model based friction compensation techniques in
the neighbourhood of pre-sliding friction".
"""

from __future__ import annotations

import numpy as np

from mjfriction.laws.rules import array
from mjfriction.progress import Tell
from mjfriction.reproduce.outcome import Claim, Line, Picture, Reproduction
from mjfriction.reproduce.table.experiments import LAWS, Tracked, run_table
from mjfriction.reproduce.table.identified import (
    Identified,
    loop_of,
)
from mjfriction.reproduce.table.machine import (
    AMPLITUDE,
    PERIOD,
    RATE,
)
from mjfriction.reproduce.table.tables import loops_left, numbers_stored, parameters_found, tracking_errors

THIN = slice(None, None, 10)


def reproduce_table(tell: Tell, seed: int = 0) -> Reproduction:
    """Run the document's experiments; ``tell`` is called at each step."""
    identified, runs = run_table(tell, seed)
    return Reproduction(
        name="table",
        title="Pre-sliding friction compensated on a machine-tool table",
        source=(
            "Lampaert, Swevers, Al-Bender and others, Comparison of model and non-model based friction compensation "
            "techniques in the neighbourhood of pre-sliding friction"
        ),
        how=_how(identified),
        tables=(
            tracking_errors(runs),
            parameters_found(identified),
            loops_left(identified),
            numbers_stored(identified),
        ),
        pictures=_pictures(runs, identified),
        claims=_claims(runs),
        differs=_differs(runs),
    )


def _pictures(runs: dict[str, Tracked], identified: Identified) -> tuple[Picture, ...]:
    time, reference = runs["PD"].time, runs["PD"].run
    last = reference.time > reference.time[-1] - PERIOD
    wanted, went = (1e6 * course[last, 0] for course in (reference.wanted, reference.played.position))
    points, curve = identified.points, identified.stribeck
    speed = np.geomspace(points.speed[0], points.speed[-1], 200)
    level = curve.law.along(speed, np.zeros((speed.size, 6)), curve.law.pack(curve.values))
    turns = identified.turns
    errors = [Line(name, time[THIN], runs[name].error[THIN]) for name in LAWS]
    both = [Line(name, time[THIN], runs[f"observer and {name}"].error[THIN]) for name in LAWS]
    smooth = 1e-6 * wanted
    return (
        Picture(
            "The reference and where the table goes under PD alone",
            "time, s",
            "position, µm",
            (Line("reference", time[THIN], wanted[THIN]), Line("PD", time[THIN], went[THIN])),
            "figure 3A",
        ),
        Picture(
            "Error under PD alone",
            "time, s",
            "error, µm",
            (Line("PD", time[THIN], runs["PD"].error[THIN]),),
            "figure 3B",
        ),
        Picture(
            "Friction at constant speeds and the Stribeck curve through it",
            "speed, µm/s",
            "friction, N",
            (Line("passes", 1e6 * points.speed, points.friction, marks=True), Line("fitted", 1e6 * speed, level)),
            "figure 4A",
            logarithmic=True,
        ),
        Picture(
            "Slow turns, and the elements' loops",
            "position, µm",
            "friction, N",
            (
                Line("measured", 1e6 * turns.position[THIN], turns.friction[THIN]),
                Line(
                    "gms",
                    1e6 * turns.position[THIN],
                    loop_of(identified.laws["gms"], turns.position, turns.motion.rate)[THIN],
                ),
            ),
            "figure 4B",
        ),
        Picture("Error with friction fed forward", "time, s", "error, µm", tuple(errors), "figure 5"),
        Picture(
            "Friction that the laws feed forward along the reference",
            "position, µm",
            "friction, N",
            tuple(Line(law, wanted[THIN], loop_of(identified.laws[law], smooth, RATE)[THIN]) for law in LAWS),
            "figure 6",
        ),
        Picture(
            "Error with the observer, at the reference's speed and at ten times that",
            "time, share of the period",
            "error, µm",
            tuple(
                Line(name, (own.time / own.time[-1])[keep], own.error[keep])
                for name, own, keep in (
                    ("observer", runs["observer"], THIN),
                    ("observer, ten times faster", runs["observer, ten times faster"], slice(None)),
                )
            ),
            "figure 8",
        ),
        Picture("Error with the observer and friction fed forward", "time, s", "error, µm", tuple(both), "figure 9"),
    )


def _claims(runs: dict[str, Tracked]) -> tuple[Claim, ...]:
    def size(name: str) -> float:
        return runs[name].peak_to_peak

    both = {law: size(f"observer and {law}") for law in LAWS}
    others = {law: error for law, error in both.items() if law not in ("gms", "leuven")}
    better = all(both[law] < min(size(law), size("observer")) for law in LAWS)
    return (
        Claim(
            "Of the document's four combinations the one with GMS is the best.",
            both["gms"] < min(others.values()),
            ", ".join(f"{law} {error:.3g} µm" for law, error in both.items()),
        ),
        Claim(
            "The observer alone loses at ten times the speed.",
            size("observer, ten times faster") > size("observer"),
            f"{size('observer'):.3g} µm, ten times faster {size('observer, ten times faster'):.3g} µm",
        ),
        Claim(
            "Feedforward and observer together beat either alone, with every law.",
            better,
            ", ".join(f"{law} {size(law):.3g} → {both[law]:.3g} µm" for law in LAWS)
            + f"; observer {size('observer'):.3g} µm",
        ),
        Claim(
            "Fed forward, Dahl does better than LuGre, whose loop has no shape to fit.",
            size("dahl") < size("lugre"),
            f"{size('dahl'):.3g} and {size('lugre'):.3g} µm",
        ),
        Claim(
            "Converting position to z before the elements are identified makes the Leuven law better.",
            both["leuven"] < both["leuven over position"],
            f"{both['leuven']:.3g} and {both['leuven over position']:.3g} µm with the observer",
        ),
    )


def _how(identified: Identified) -> tuple[str, ...]:
    elements = len(array(identified.laws["gms"].parameters, "stiffness"))
    return (
        "The machine is simulated in MuJoCo and richer than every law under test: 61 Maxwell-slip elements of two "
        "kinds of contact slipping towards the published Stribeck curve, a level that varies by 3.6 % along the "
        "stroke, cogging with one wave at no harmonic of the screw, a current loop of 400 Hz, 16 bit current with "
        "noise, 10 nm position.",
        "Everything that a controller knows was identified from the machine's own logs: cogging and the Stribeck curve "
        "from 12 speeds forward and backward, elements from slow turns by bounded least squares "
        f"({elements} of them, the number chosen on turns not fitted), "
        "Dahl and LuGre by curve fitting.",
        "As in the document, what slow turns do not show (C of GMS, σ₁ of LuGre and Leuven) is set for the least "
        "maximum error along the reference, with feedforward alone.",
        f"Reference: ±{1e6 * AMPLITUDE:g} µm with two inner loops in {PERIOD:g} s. Its figure shows no numbers that "
        "can be read.",
    )


def _differs(runs: dict[str, Tracked]) -> tuple[str, ...]:
    gms = runs["PD"].peak_to_peak / runs["observer and gms"].peak_to_peak
    return (
        f"With GMS and the observer the error is {gms:.3g} times smaller than PD's, against 18 printed: our machine's "
        "contacts are elements, of which GMS is a coarser choice, while a real one's are not.",
        "The document's δ_l = 0.1 is read as 1/δ_l: as printed in (5) the bristle would hardly move before it "
        "slides, and the law would leave tens of newtons of the measured loops.",
        "LuGre, whose loop has no shape to fit, leaves more of the slow turns than Dahl; fed forward it makes up "
        "for that by its σ₁, which is set for the least error there.",
    )
