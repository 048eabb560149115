"""The arms' numbers beside those that the manipulator document prints."""

from __future__ import annotations

from mjfriction.body.gravity_pose import GravityClass
from mjfriction.identify.bristle_fit import BRISTLE
from mjfriction.reproduce.manipulator.arm import ARMS, stated_arm
from mjfriction.reproduce.manipulator.experiments import LAWS, Arm, Told
from mjfriction.reproduce.outcome import Row, Table

PRINTED_STATIC = (
    (0.21679272, 0.00761328),
    (0.30840432, 0.05687789),
    (0.20677194, 0.02160639),
    (0.06630509, 0.01278170),
    (0.60089415, 0.01720321),
    (0.51918911, 0.00915342),
)
"""Table 3: RMS of Coulomb-viscous and of the static law, N·m of the motor."""

PRINTED_CURRENT = (
    (0.29989036, 0.21385734),
    (0.35687425, 0.26258745),
    (0.22458652, 0.15698745),
    (0.40256359, 0.31885426),
    (0.32458654, 0.24758865),
    (0.28456245, 0.20124577),
)
"""Table 4: RMS of currents with Coulomb-viscous and with the dynamic law, A."""


def gravity_classes(arms: list[Arm]) -> Table:
    """Return how gravity loads every joint of the arms."""
    joints = range(len(arms[0].classes))
    rows = tuple(Row(f"joint {i + 1}", tuple(arm.classes[i] for arm in arms)) for i in joints)
    return Table("How gravity loads the joints, found from the models", tuple(arm.name for arm in arms), rows)


def static_parameters(arm: Arm) -> Table:
    """Return law (14) as identified in both ways, beside the stated one."""
    rows = []
    names = ("static", "stribeck_fall", "viscous", "viscous_bend", "stribeck_steepness")
    truth = stated_arm(arm.name)
    for i, fit in enumerate(arm.fits):
        (law,) = truth.table.joint[i].friction or ()
        rows.append(Row(f"J{i + 1} by least squares", tuple(fit.static.values[name] for name in names)))
        if fit.procedure is not None:
            rows.append(Row(f"J{i + 1} by the slope near zero", tuple(fit.procedure.values[name] for name in names)))
        rows.append(
            Row(f"J{i + 1} {'printed' if arm.name == ARMS[0] else 'stated'}", tuple(law.value(name) for name in names))
        )
    return Table(
        f"{arm.name}: Table 1, static parameters on the motor's side",
        ("τ_s N·m", "τ_sc N·m", "τ_v N·m·s", "τ_nlv N·m·s²", "δ s"),
        tuple(rows),
        "The simulated machine has these parameters and, beyond them, levels that grow with the load it carries.",
    )


def bristles_found(arm: Arm) -> Table:
    """Return the bristles identified from the near-sinusoidal motion, beside the true ones."""
    rows, truth = [], stated_arm(arm.name)
    for i, fit in enumerate(arm.bristles):
        (law,) = truth.table.joint[i].friction or ()
        cells = [
            cell for name in BRISTLE for cell in (fit.values[name], fit.together[name], fit.half[name], law.value(name))
        ]
        rows.append(Row(f"J{i + 1}", (*cells, *(1e3 * left for left in fit.rms))))
    true = "printed" if arm.name == ARMS[0] else "stated"
    return Table(
        f"{arm.name}: Table 2, bristles from the near-sinusoidal motion",
        (
            *("σ₀ N·m/rad, statics held", "σ₀ all together", "± 95 %", f"σ₀ {true}"),
            *("σ₁ N·m·s/rad, statics held", "σ₁ all together", "± 95 % ", f"σ₁ {true}"),
            *("mN·m left by the statics", "with the bristle", "by all together"),
        ),
        tuple(rows),
        "By the error of the friction simulated along the wanted motion, statics from the passes held; then all "
        "together to the motion and the passes. Where an interval is wider than its value, the log does not tell it.",
    )


def pendulums(arms: list[Arm]) -> Table:
    """Return the deviation of friction from the machine's own, at the joints that gravity loads.

    It is given for passes one way with gravity removed as a pendulum's, and for passes both ways.
    """
    rows = tuple(
        Row(f"{arm.name}, joint {i + 1}", tuple(1e3 * own for own in fit.off))
        for arm in arms
        for i, fit in enumerate(arm.fits)
        if arm.classes[i] != GravityClass.NEVER.value
    )
    return Table(
        "Friction with gravity taken away in three ways: RMS off the machine's own, mN·m of the motor",
        ("pendulum of the model", "pendulum by least squares", "forward and backward"),
        rows,
        "Gravity of these simulated links is a pendulum's, so that a fitted one takes it away as well as passes both "
        "ways do; that of a machine also has hoses and balancers in it.",
    )


def load_found(arms: list[Arm]) -> Table:
    """Return what a payload adds to friction, as identified and as it truly is."""
    rows = []
    for arm in arms:
        for own in arm.loads:
            found, half = own.found.values, own.found.half
            cells = [
                cell
                for name, true in (("static_load", own.static), ("fall_load", own.fall))
                for cell in (found[name], half[name], true)
            ]
            rows.append(Row(f"{arm.name}, joint {own.joint + 1}", (*own.load, *cells)))
    return Table(
        "Extension (30) to (32): what each N·m of load adds, from passes without and with the rated payload",
        ("load N·m", "with payload", "τ_s,m", "± 95 %", "true", "τ_sc,m", "± 95 % ", "true "),
        tuple(rows),
        "On the motor's side, law arctan_load fitted to one map of both runs; the load is half the sum of passes "
        "forward and backward. The document found the relation to be about linear and printed no figures.",
    )


def static_errors(arm: Arm) -> Table:
    """Return the errors of Coulomb-viscous friction and the static law on held-out passes."""
    rows = []
    for i, fit in enumerate(arm.fits):
        plain, static = fit.checked
        printed = PRINTED_STATIC[i] if arm.name == ARMS[0] else None
        rows.append(
            Row(
                f"joint {i + 1}",
                (
                    plain,
                    static,
                    plain / static,
                    *(printed or (None, None)),
                    None if printed is None else printed[0] / printed[1],
                ),
            )
        )
    return Table(
        f"{arm.name}: Table 3, RMS on new passes at other speeds, N·m of the motor",
        (
            "Coulomb-viscous",
            "static law",
            "times better",
            "printed: Coulomb-viscous",
            "printed: static",
            "printed: times better",
        ),
        tuple(rows),
    )


def current_errors(arm: Arm, motion: str, title: str) -> Table:
    """Return every law's error of the currents along a motion, the arm's ``slow`` or ``work``."""
    told: Told = getattr(arm, motion)
    errors = [told.rms(law) for law in LAWS]
    rows = []
    for i in range(len(arm.fits)):
        printed = PRINTED_CURRENT[i] if arm.name == ARMS[0] and motion == "slow" else None
        cells = [float(error[i]) for error in errors]
        rows.append(
            Row(
                f"joint {i + 1}",
                (
                    *cells,
                    cells[0] / cells[2],
                    *(printed or (None, None)),
                    None if printed is None else printed[0] / printed[1],
                ),
            )
        )
    return Table(
        f"{arm.name}: {title}, RMS error in A",
        (*LAWS, "times better", "printed: Coulomb-viscous", "printed: dynamic", "printed: times better"),
        tuple(rows),
    )
