"""Friction of a hydraulic cylinder from constant voltages: law (2) in variants, each direction fitted separately.

At constant speed, friction is the force of the chambers, F = p₁A₁ − p₂A₂ (Bonchis, Ha, Corke, Rye, eq. 1).  The most
likely parameters under the points' noise are those of weighted least squares.  x₂ stands in an exponent; for each value
of it the rest is linear, with x₁, x₅ ≥ 0.  The variant is chosen by the Bayesian information criterion with known
noise, χ² + k·ln n: a parameter must pay for itself.

F measured in this way is A₁·(p₁ − p₂) + (A₁ − A₂)·p₂, whatever friction is.  A variant with both x₃ and x₄ free
therefore fits any cylinder without saying anything about its friction, and â from it is zero.  Steady speeds determine
one combination of the two: variant 5 puts it in x₄, and is taken for prediction (:func:`choose_variant`).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy.optimize import lsq_linear, minimize_scalar

from mjfriction.errors import LogError
from mjfriction.identify.phases import constant_speed_phases
from mjfriction.laws.law import Floats
from mjfriction.laws.rules import Values
from mjfriction.record.log import HEAD_PRESSURE, ROD_PRESSURE, Log, check_joints
from mjfriction.robot.bandwidth import choose_cutoff
from mjfriction.robot.measured_motion import measured_motion
from mjfriction.robot.robot import Robot

Way = Literal["extending", "retracting"]
NAMES = ("level", "growth", "pressure_difference", "rod_pressure", "viscous")
VARIANTS: dict[int, tuple[str, ...]] = {
    1: ("level", "growth", "pressure_difference", "viscous"),
    2: NAMES,
    3: ("level", "pressure_difference", "rod_pressure", "viscous"),
    4: ("level", "viscous"),
    5: ("level", "rod_pressure", "viscous"),
}
"""The parameters that each of the document's models 1 to 4 keeps, and ours, 5."""

TELLING = (4, 5)  # variants that say something about friction; 1 is ambiguous: x₂ and x₅ may mimic x₄

STEEPEST = 5.0  # largest x₂ times the highest speed that is searched
PIECES = 8  # of a phase, whose scatter shows how well its mean is known
GRID = 41  # values of x₂, the best of which starts the search


@dataclass(frozen=True)
class SteadyPoints:
    """Phases of constant speed of a cylinder.

    ``speed`` (n,) m/s and ``force`` (n,) N against the motion are signed; ``head`` and ``rod`` (n,) Pa are the
    chambers' pressures; ``error`` (n,) N is how well each force is known.
    """

    speed: Floats
    force: Floats
    head: Floats
    rod: Floats
    error: Floats

    def towards(self, way: Way) -> SteadyPoints:
        """Return the points of one direction."""
        own = self.speed > 0.0 if way == "extending" else self.speed < 0.0
        return SteadyPoints(*(values[own] for values in (self.speed, self.force, self.head, self.rod, self.error)))


@dataclass(frozen=True)
class Variant:
    """One of the models fitted to one direction: its ``values``, residual (``rms``, N) and Bayesian ``criterion``."""

    number: int
    way: Way
    values: dict[str, float]
    rms: float
    criterion: float

    @property
    def parameters(self) -> dict[str, float]:
        """The values under the names of the law ``pressure``."""
        return {f"{name}_{self.way}": value for name, value in self.values.items()}


def steady_points(logs: list[Log], robot: Robot, joint: str) -> SteadyPoints:
    """Return the phases of constant speed in a cylinder's logs, each by its means.

    Raises :class:`LogError` where no cylinder moves the joint, a log lacks the chambers' pressures, or the joint never
    moves at a constant speed.
    """
    place = robot.joints.index(robot.joint(joint).name)
    of = robot.joint(joint).hydraulics
    if of is None:
        raise LogError(f"joint '{joint}' of '{robot.name}' is moved by no cylinder; law 'pressure' is for one that is")
    body = robot.body()
    rows = []
    for log in logs:
        check_joints(log, robot.name, robot.joints)
        motion = measured_motion(log, robot, body, choose_cutoff(log, robot, body))
        names = (f"{HEAD_PRESSURE}.{joint}", f"{ROD_PRESSURE}.{joint}")
        missing = [name for name in names if name not in motion.columns]
        if missing:
            raise LogError(f"{log.source}: has no column '{missing[0]}'; record both chambers' pressures, in Pa")
        for phase in constant_speed_phases(motion):
            if phase.joint != place:
                continue
            own = slice(phase.first, phase.past)
            head, rod = (motion.columns[name][own] for name in names)
            force = of.head_area * head - of.rod_area * rod
            # The scatter of the phase's pieces shows how well its mean is known, slow drifts included.
            pieces = [float(np.mean(piece)) for piece in np.array_split(force, PIECES)]
            error = float(np.std(pieces, ddof=1)) / np.sqrt(PIECES)
            speed = float(np.mean(motion.velocity[own, place]))
            rows.append((speed, float(np.mean(force)), float(np.mean(head)), float(np.mean(rod)), error))
    if not rows:
        raise LogError(
            f"joint '{joint}' goes at no constant speed; record constant voltages (plan --protocol voltages) that are "
            "held until the speed settles"
        )
    speed, force, head, rod, error = np.array(rows).T
    least = max(float(np.median(error)), 1e-9 * float(np.max(np.abs(force))))
    return SteadyPoints(speed, force, head, rod, np.maximum(error, least))


def fit_variant(points: SteadyPoints, way: Way, number: int) -> Variant:
    """Fit one of the document's models to one direction.

    Raises :class:`LogError` unless there are more speeds than the model has parameters.
    """
    own, names = points.towards(way), VARIANTS[number]
    if own.speed.size <= len(names):
        raise LogError(
            f"model {number} of law 'pressure' has {len(names)} parameters, and {own.speed.size} speeds were recorded "
            f"{way}; record at least {len(names) + 1}"
        )
    speed, force = np.abs(own.speed), own.force * np.sign(own.speed)
    difference = (own.head - own.rod) * np.sign(own.speed)
    columns = {"pressure_difference": difference, "rod_pressure": own.rod, "viscous": speed}

    def solved(growth: float) -> tuple[Floats, float]:
        table = np.column_stack([np.exp(growth * speed), *(columns[name] for name in names if name in columns)])
        size = np.maximum(np.sqrt(np.mean(np.square(table), axis=0)), 1e-300)
        low = np.array([0.0 if name in ("level", "viscous") else -np.inf for name in names if name != "growth"])
        found = lsq_linear(table / size / own.error[:, None], force / own.error, bounds=(low, np.inf))
        solution = np.asarray(found.x / size)
        return solution, float(np.sum(np.square((force - table @ solution) / own.error)))

    growth = 0.0
    if "growth" in names:
        most = STEEPEST / float(np.max(speed))
        grid = np.linspace(-most, most, GRID)
        near = grid[int(np.argmin([solved(value)[1] for value in grid.tolist()]))]
        bounds = (near - grid[1] + grid[0], near + grid[1] - grid[0])
        growth = float(minimize_scalar(lambda x: solved(x)[1], bounds=bounds, method="bounded").x)
    linear, chi_squared = solved(growth)
    values = dict(zip([name for name in names if name != "growth"], linear.tolist(), strict=True))
    if "growth" in names:
        values["growth"] = growth
    table = np.column_stack([np.exp(growth * speed), *(columns[name] for name in names if name in columns)])
    rms = float(np.sqrt(np.mean(np.square(force - table @ linear))))
    return Variant(number, way, values, rms, chi_squared + len(names) * float(np.log(force.size)))


def choose_variant(points: SteadyPoints, way: Way) -> tuple[Variant, dict[int, Variant]]:
    """Return the variant to take in a direction, and by their numbers all variants that the recorded speeds allow.

    The one to take has the least criterion among those that say something about friction.
    """
    count = points.towards(way).speed.size
    tried = {number: fit_variant(points, way, number) for number in TELLING}
    tried |= {number: fit_variant(points, way, number) for number, names in VARIANTS.items() if count > len(names)}
    return min((tried[number] for number in TELLING), key=lambda variant: variant.criterion), tried


def pressure_law(extending: Variant, retracting: Variant) -> Values:
    """Return the law's parameters from one fitted model for each direction."""
    return {**extending.parameters, **retracting.parameters}
