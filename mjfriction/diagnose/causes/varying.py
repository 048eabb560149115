"""Friction that varies over the log: with temperature or running time (friction.temperature), or in a step at one
moment (event.change).
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import replace
from typing import ClassVar, final

import numpy as np

from mjfriction.diagnose.causes.cause import SHIFTS, JointCause, Quantity, Site
from mjfriction.identify.gap import Gap
from mjfriction.identify.regression import Columns
from mjfriction.laws.ambient import ROOM_TEMPERATURE
from mjfriction.parameter import Parameter
from mjfriction.record.fault import moment
from mjfriction.record.log import Floats
from mjfriction.robot.friction import stated_levels
from mjfriction.robot.friction_tables import Event, Thermal, WarmUp
from mjfriction.robot.robot import Robot
from mjfriction.robot.rubbing import warmed

COULOMB = Parameter("coulomb", "{force}", "change of the Coulomb level")
VISCOUS = Parameter("viscous", "{force}·s/{length}", "change of the damping")
COULOMB_PER_KELVIN = Parameter("coulomb_per_kelvin", "{force}/K", "growth of the Coulomb level with temperature")
VISCOUS_PER_KELVIN = Parameter("viscous_per_kelvin", "{force}·s/({length}·K)", "growth of the damping with temperature")
TIME_CONSTANT = Parameter("time_constant", "s", "time after which 63 % of the change is over", lower=1e-3)
MOMENT = Parameter("time", "s", "moment of the step, on the log's clock")

LEAST_WARMING = 1.0  # K, least range of temperature over a log for its effect to show
SPEEDS = (0.1, 0.9)  # quantiles of a joint's speed, slow and fast, at which the changes of friction are compared
# Fraction of its change when slow by which friction may change the other way when fast: damping is hardly known.
OPPOSITE = 0.5
MOST_CHANGE = 4.0  # times the stated friction, at a fast speed, by which friction may change within a log
# Early or late in the course, a joint may usually be slower.  This quantile of its speed then has to reach this
# fraction of its usual speed in the other part, or nothing tells the change over time from one over speed.
FASTER, ALIKE = 0.75, 0.25
MOMENTS = 60
EDGE = 0.06  # fraction of the joint's motion at each end where no step is looked for
SLOWEST = 3.0  # longest time constant, in multiples of the log's length: a longer one makes a straight line
FASTEST = 3.0  # s, shortest time constant: nothing of a drive's weight warms in less
OFF_EDGE = 1.05  # multiple of the shortest time constant up to which it is some event at the log's beginning
APART = 2.5  # largest ratio of one time constant that is tried to the next


class Varying(JointCause):
    """Friction that follows one course of time c(t): (C·sgn v + V·v)·c."""

    covariate = "time"
    picture = "turned"
    beyond: ClassVar[float] = 1.0  # how far c may extend before and after the log, in multiples of its range in it
    least_of_friction = 0.0175  # for a step of twice this, since refitted levels absorb half of it

    @abstractmethod
    def course(self, gap: Gap, site: Site) -> Floats:
        """Return c along the motion, (n,)."""

    def samples(self, gap: Gap, site: Site) -> Floats:
        """Direction and velocity times the course, (n, 2)."""
        course = self.course(gap, site)
        return np.column_stack([gap.forward(site.joint) * course, gap.motion.velocity[:, site.joint] * course])

    def level_shifts(self, gap: Gap, site: Site, strengths: Floats) -> Floats:
        """Along the range of the course, extended on both sides by how far it may go on before and after the log."""
        course = self.course(gap, site)
        beyond = self.beyond * np.ptp(course)
        return np.outer(np.linspace(np.min(course) - beyond, np.max(course) + beyond, SHIFTS), strengths)

    def admissible(self, gap: Gap, site: Site, strengths: Floats) -> bool:
        """A change by at most four times the friction stated for a joint's fast speed, that shows at alike speeds.

        Where a joint only creeps from some moment on, what its friction does then is of its speed and not of the time.
        """
        coulomb, viscous = stated_levels(gap.robot.table.joint[site.joint])
        speed, course = self._speeds(gap, site), self._at_rows(gap, site)
        fast = float(np.quantile(speed, SPEEDS[1]))
        change = abs(float(strengths @ (1.0, fast))) * float(np.ptp(course))
        stated = coulomb + viscous * fast
        if stated > 0.0 and change > MOST_CHANGE * stated:
            return False
        late = course > 0.5 * (np.min(course) + np.max(course))
        if not np.any(late):
            return False  # the course is the same wherever the joint moves clearly
        slower, faster = sorted((speed[own] for own in (late, ~late)), key=np.median)
        return float(np.quantile(slower, FASTER)) > ALIKE * float(np.median(faster))

    def one_way(self, gap: Gap, site: Site, strengths: Floats) -> bool:
        """Return whether friction rises or falls as a whole.

        A change that lowers it when slow and raises it when fast, or the reverse, is another curve over speed and no
        course of time.
        """
        slow, fast = (strengths[0] + strengths[1] * float(one) for one in np.quantile(self._speeds(gap, site), SPEEDS))
        return bool(slow * fast >= 0.0 or abs(fast) < OPPOSITE * abs(slow))

    def _at_rows(self, gap: Gap, site: Site) -> Floats:
        # The course at the rows where the joint moves clearly.
        return np.asarray(np.interp(_clear(gap, site), gap.motion.time, self.course(gap, site)))

    def _speeds(self, gap: Gap, site: Site) -> Floats:
        return np.asarray(np.abs(gap.at_rows("velocity")[gap.clear[:, site.joint], site.joint]))

    def quantities(self, gap: Gap, site: Site) -> tuple[Quantity, ...]:
        """The changes of Coulomb level and damping."""
        return (Quantity(COULOMB), Quantity(VISCOUS))


def _temperature(gap: Gap, joint: int) -> Floats | None:
    logged = gap.motion.columns.get(f"temperature.{gap.robot.joints[joint]}")
    return logged if logged is not None and np.ptp(logged) >= LEAST_WARMING else None


def _time_constants(gap: Gap) -> tuple[float, float]:
    return FASTEST, SLOWEST * float(np.ptp(gap.motion.time))


def _words(strengths: Floats, sliding: bool) -> str:
    force, speed = ("N", "m/s") if sliding else ("N·m", "rad/s")
    return f"{strengths[0]:+.3g} {force} and {strengths[1]:+.3g} {force} per {speed}"


@final
class Warming(Varying):
    """Friction follows the logged temperature."""

    name = "friction.temperature"

    def sites(self, gap: Gap) -> list[Site]:
        """Every examined joint whose temperature was logged and changed."""
        return [site for site in super().sites(gap) if _temperature(gap, site.joint) is not None]

    def course(self, gap: Gap, site: Site) -> Floats:
        """The logged temperature above room temperature, K."""
        logged = _temperature(gap, site.joint)
        assert logged is not None, "sites lets no joint without a temperature pass"
        return logged - ROOM_TEMPERATURE

    def quantities(self, gap: Gap, site: Site) -> tuple[Quantity, ...]:
        """The growth per kelvin, stated plus change."""
        stated = gap.robot.table.joint[site.joint].thermal
        return (
            Quantity(COULOMB_PER_KELVIN, shift=stated.coulomb_per_kelvin),
            Quantity(VISCOUS_PER_KELVIN, shift=stated.viscous_per_kelvin),
        )

    def extend(self, robot: Robot, site: Site, strengths: Floats) -> Robot:
        """Change the growth of the joint's friction per kelvin."""
        joint = robot.joints[site.joint]
        table = robot.joint(joint)
        stated = table.thermal
        changed = Thermal(
            coulomb_per_kelvin=stated.coulomb_per_kelvin + float(strengths[0]),
            viscous_per_kelvin=stated.viscous_per_kelvin + float(strengths[1]),
            reference_temperature=stated.reference_temperature,
        )
        return robot.with_joint(table.model_copy(update={"thermal": changed}))

    def evidence(self, gap: Gap, site: Site, strengths: Floats) -> str:
        """Give the change over the log's range of temperature."""
        logged = _temperature(gap, site.joint)
        assert logged is not None, "sites lets no joint without a temperature pass"
        span = float(np.ptp(logged))
        change = _words(strengths * span, gap.body.sliding[site.joint])
        return f"as the joint warms by {span:.3g} K its friction changes by {change}"


@final
class WarmUpDrift(Varying):
    """Friction settles with running time, where no temperature was logged or friction does not follow it."""

    name = "friction.temperature"
    shape_parameters = (TIME_CONSTANT,)

    def sites(self, gap: Gap) -> list[Site]:
        """Every examined joint, with time constants from the shortest on."""
        low, high = _time_constants(gap)
        if low >= high:
            return []
        grid = np.geomspace(low, high, 1 + int(np.ceil(np.log(high / low) / np.log(APART))))
        begin = float(gap.motion.time[0])
        return [replace(site, shape=(float(tau),), begin=begin) for site in super().sites(gap) for tau in grid]

    def shape_bounds(self, gap: Gap, site: Site) -> list[tuple[float, float]]:
        """From the fastest warm-up to one that is a straight line over the log."""
        return [_time_constants(gap)]

    def own_shape(self, gap: Gap, site: Site) -> bool:
        """A time constant above the lower bound: at the bound, it is some event as the log began."""
        return site.shape[0] > OFF_EDGE * FASTEST

    def course(self, gap: Gap, site: Site) -> Floats:
        """The completed share of a warm-up that began with the log."""
        return warmed(gap.motion.time - site.begin, site.shape[0])

    def extend(self, robot: Robot, site: Site, strengths: Floats) -> Robot:
        """State the warm-up."""
        joint, (coulomb, viscous) = robot.joints[site.joint], strengths.tolist()
        warm = WarmUp(coulomb=coulomb, viscous=viscous, time_constant=site.shape[0], begin=site.begin)
        return robot.with_joint(robot.joint(joint).model_copy(update={"warm_up": warm}))

    def evidence(self, gap: Gap, site: Site, strengths: Floats) -> str:
        """Give the drift over the log."""
        course = self.course(gap, site)
        change = _words(strengths * float(course[-1] - course[0]), gap.body.sliding[site.joint])
        return f"friction drifts smoothly over the log, by {change} from its beginning to its end"


def _clear(gap: Gap, site: Site) -> Floats:
    # The times of clear rows, at which the joint moves: at rest, a change cannot be told from friction that holds it.
    return np.asarray(gap.chain.time[gap.clear[:, site.joint]])


@final
class Step(Varying):
    """Friction steps at one moment and stays."""

    name = "event.change"
    beyond = 0.0
    shape_parameters = (MOMENT,)
    relative_shape = False

    def sites(self, gap: Gap) -> list[Site]:
        """Every examined joint, with moments spread over the time it moves."""
        spread = np.linspace(EDGE, 1.0 - EDGE, MOMENTS)
        return [site.shaped((float(t),)) for site in super().sites(gap) for t in np.quantile(_clear(gap, site), spread)]

    def shape_bounds(self, gap: Gap, site: Site) -> list[tuple[float, float]]:
        """Within the time that the joint moves."""
        low, high = np.quantile(_clear(gap, site), [EDGE, 1.0 - EDGE])
        return [(float(low), float(high))]

    def shape_steps(self, gap: Gap, site: Site) -> tuple[float, ...]:
        """About half of the time between two of the moments that are tried."""
        return (0.5 * float(np.ptp(_clear(gap, site))) / MOMENTS,)

    def own_shape(self, gap: Gap, site: Site) -> bool:
        """A step away from the edges of the search range.

        A step at an edge is a level that is off, except for what happened at that end of the log.
        """
        low, high = self.shape_bounds(gap, site)[0]
        margin = (high - low) / MOMENTS
        return bool(low + margin < site.shape[0] < high - margin)

    def shape_resolution(self, gap: Gap, site: Site) -> tuple[float, ...]:
        """The time from row to row: the low-pass of efforts smears a step by as much."""
        return (gap.chain.step,)

    def screening(self, gap: Gap, sites: Sequence[Site], every: int) -> Columns:
        """Direction and velocity at the rows, zero before each moment: the filter's effect on the edge is neglected."""
        joint, time = sites[0].joint, gap.chain.time[::every, None]
        after = time >= np.array([site.shape[0] for site in sites])
        sources = (gap.at_rows("forward"), gap.at_rows("velocity"))
        return {joint: np.stack([after * source[::every, [joint]] for source in sources], axis=2)}

    def course(self, gap: Gap, site: Site) -> Floats:
        """Zero before the moment, one after."""
        return np.asarray((gap.motion.time >= site.shape[0]).astype(np.float64))

    def extend(self, robot: Robot, site: Site, strengths: Floats) -> Robot:
        """State the event."""
        joint = robot.joints[site.joint]
        table = robot.joint(joint)
        event = Event(time=site.shape[0], coulomb=float(strengths[0]), viscous=float(strengths[1]))
        return robot.with_joint(table.model_copy(update={"events": (*table.events, event)}))

    def evidence(self, gap: Gap, site: Site, strengths: Floats) -> str:
        """Give the moment and the step."""
        change = _words(strengths, gap.body.sliding[site.joint])
        return f"at {moment(site.shape[0])} s friction steps by {change} and stays"
