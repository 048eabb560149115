"""drive.elasticity: a compliant transmission, whose link lags in proportion to its load or oscillates on it."""

from __future__ import annotations

import functools
from collections.abc import Sequence
from dataclasses import replace
from typing import ClassVar, final

import numpy as np

from mjfriction.diagnose.causes.cause import Quantity, Site, near_around
from mjfriction.diagnose.causes.moved_link import (
    NEAR,
    MovedLink,
    as_drawn,
    changed,
    felt_by_itself,
    lagging,
    noise_of_inertia,
    own_slopes,
)
from mjfriction.identify.gap import Gap
from mjfriction.identify.regression import Columns
from mjfriction.parameter import Parameter
from mjfriction.record.log import Floats
from mjfriction.record.motion import smooth_derivatives
from mjfriction.robot.effort import given_along, in_motion, without_offsets
from mjfriction.robot.friction import stated_levels
from mjfriction.robot.robot import Robot
from mjfriction.robot.rubbing import direction
from mjfriction.robot.transmission import (
    FLIGHT_RATE,
    LEAST_INERTIA,
    LOAD_BAND,
    damper_of,
    natural_frequency,
    swinging,
)
from mjfriction.sim.ringing import deflection

COMPLIANCE = Parameter("compliance", "{length}/{force}", "how far the transmission gives per load", lower=0.0)
DAMPING_RATIO = Parameter("damping_ratio", "1", "damping of the link on what gives, over the critical one", lower=0.0)
MOST_GIVEN = 0.35  # rad, largest deflection under load: series elastic joints give by as much
MOST_GIVEN_ALONG = 0.2  # m, the same of a sliding joint
# A link that swings faster, and gives by less under its largest load, rad and m, is as stiff as those of usual arms.
USUALLY_SWINGS, USUALLY_GIVES, USUALLY_GIVES_ALONG = 12.0, 3e-3, 5e-4
RESONANCES = tuple(2.5 * 1.1**k for k in range(-12, 25))  # Hz: from 0.8 to 25 Hz
RESONANCE_BAND = 0.8  # fraction of the position filter's cutoff below which a resonance is visible
FINER_RESONANCE, NEIGHBOURS = 1.1, 5  # half a step of these, as a ratio of compliances, and how many are tried there
GIVES = tuple(0.15 * 0.75**k for k in range(20))  # deflections at the largest load, rad or m: from 0.15 to 0.0006
FINER_GIVE = 1.15  # half a step of these, as a ratio
HARDENING = Parameter("hardening", "{force}/{length}³", "torque per deflection cubed, in addition", lower=0.0)
STIFFER = (1.4, 1.9, 2.8)  # ratios to try of torque to deflection under the largest load to that near rest
FINER_HARDENING, FINER_DAMPING = 1.5, 2.0  # largest ratios to try around a spring that hardens
LEAST_HARDENING = 0.01  # fraction of the usual load that a spring that hardens carries by that, at least
DAMPINGS = (0.025, 0.05, 0.1, 0.2, 0.4)  # damping ratios to try
# Damping ratio at which resonances are screened: with less, a link oscillates so long that columns for a resonance not
# quite its own fall out of phase with it.
SCREENED_AT = 0.2
PROMISES = (0.4, NEAR[1])  # a link that is damped less swings on while columns screened so do not
SCREENING_RATE = 500.0  # Hz, integration rate that is enough to rank resonances


def _near_compliances(site: Site) -> list[float]:
    # Up to halfway to the neighbours on the grid.
    near = np.geomspace(site.around / FINER_RESONANCE, site.around * FINER_RESONANCE, NEIGHBOURS)
    return [float(compliance) for compliance in near]


def most_given(gap: Gap, joint: int) -> float:
    """Return how far a joint's transmission may give under the largest load, rad or m."""
    return MOST_GIVEN_ALONG if gap.body.sliding[joint] else MOST_GIVEN


class _Elasticity(MovedLink):
    """The transmission is compliant: the link lags its sensor by compliance · load."""

    name = "drive.elasticity"
    carries_friction: ClassVar[bool]
    rubs_with_link: ClassVar[bool] = False

    def load(self, gap: Gap, joint: int) -> Floats:
        """Return what the transmission carries, (n,)."""
        load = gap.known.effort.load[:, joint]
        return load + gap.known.effort.friction[:, joint] if self.carries_friction else load

    def shift(self, gap: Gap, site: Site) -> list[Floats]:
        """The load, low-passed, and its two derivatives."""
        joint = site.joint

        def made() -> Columns:
            return {joint: np.stack(smooth_derivatives(gap.motion, self.load(gap, joint), LOAD_BAND))}

        return list(gap.kept.recall(f"load {self.carries_friction} {joint}", made)[joint])

    def quantities(self, gap: Gap, site: Site) -> tuple[Quantity, ...]:
        """The compliance, stated plus change."""
        return (Quantity(COMPLIANCE, shift=gap.robot.table.joint[site.joint].transmission.compliance),)

    def admissible(self, gap: Gap, site: Site, strengths: Floats) -> bool:
        """The total compliance is positive, and the added deflection stays below the largest one."""
        stated = gap.robot.table.joint[site.joint].transmission.compliance
        return bool(
            stated + strengths[0] > 0.0 and self.most(gap, site, float(strengths[0]))[0] < most_given(gap, site.joint)
        )

    def usual(self, gap: Gap, site: Site, strengths: Floats) -> bool:
        """As stiff as the gears of most arms, which their models leave out: 12 Hz or more, and 3 mrad (0.5 mm) at most.

        A compliance that carries no friction is none of a gear.
        """
        compliance, inertia = abs(float(strengths[0])), np.maximum(own_slopes(gap, site.joint)[2], LEAST_INERTIA)
        stiff = float(np.median(inertia)) * compliance * (2.0 * np.pi * USUALLY_SWINGS) ** 2 < 1.0
        little = USUALLY_GIVES_ALONG if gap.body.sliding[site.joint] else USUALLY_GIVES
        return not self.rubs_with_link and stiff and self.most(gap, site, compliance)[0] < little

    def most(self, gap: Gap, site: Site, compliance: float) -> tuple[float, float]:
        """Return how far the transmission gives under the largest load, and that load, N·m or N."""
        load = float(np.max(np.abs(self.load(gap, site.joint))))
        return float(deflection(np.array([compliance * load]), compliance * self.hardening(site))[0]), load

    def hardening(self, site: Site) -> float:
        """Return the coefficient of the deflection cubed, N·m/rad³ or N/m³: by default the spring is straight."""
        return 0.0

    def extend(self, robot: Robot, site: Site, strengths: Floats) -> Robot:
        """Change the compliance, and state on which side of it friction acts."""
        own = robot.table.joint[site.joint].transmission
        compliance = max(0.0, own.compliance + float(strengths[0]))
        where = {"carries_friction": self.carries_friction, "rubs_with_link": self.rubs_with_link}
        softer = own.model_copy(update={"compliance": compliance, **where})
        return changed(robot, site, transmission=softer)

    def evidence(self, gap: Gap, site: Site, strengths: Floats) -> str:
        """Give the deflection at the largest load."""
        sliding = gap.body.sliding[site.joint]
        given, most = self.most(gap, site, float(strengths[0]))
        return (
            f"the link lags its sensor in step with the load, by {given:.3g} "
            f"{'m' if sliding else 'rad'} at {most:.3g} {'N' if sliding else 'N·m'}"
        )


@final
class Elasticity(_Elasticity):
    """Friction acts on the motor's side of the compliance."""

    carries_friction = False


@final
class LinkSideElasticity(_Elasticity):
    """Friction acts on the link's side of the compliance, and so belongs to the load."""

    carries_friction = True


@final
class SensorElasticity(_Elasticity):
    """The compliance carries no friction, as in a sensor's mount, and friction follows the link.

    Between the reversal of the link and that of its sensor, friction points the other way.  On wrists with little to
    carry, that is the only visible effect.  How long it lasts is not linear in the compliance, so the columns are
    computed around a compliance that is searched.
    """

    carries_friction = False
    rubs_with_link = True
    curved = True
    tangent_step = 0.1  # large, because friction changes sign sample by sample

    def sites(self, gap: Gap) -> list[Site]:
        """Every joint with a stated Coulomb level, with many deflections at its largest load."""
        sites = [site for site in super().sites(gap) if stated_levels(gap.robot.table.joint[site.joint])[0] > 0.0]
        most = {site.joint: float(np.max(np.abs(self.load(gap, site.joint)))) for site in sites}
        return [replace(site, around=give / most[site.joint]) for site in sites for give in GIVES]

    def screening(self, gap: Gap, sites: Sequence[Site], every: int) -> Columns:
        """The torque at the joint itself."""
        joint = sites[0].joint
        felt = [gap.reported(joint, self.samples(gap, site))[::every] for site in sites]
        return {joint: np.stack(felt, axis=1)}

    def _beside(self, gap: Gap, site: Site) -> Floats:
        if site.around == 0.0:
            return super()._beside(gap, site)  # without a compliance: only tests whether any would be felt
        coulomb, viscous = stated_levels(gap.robot.table.joint[site.joint])
        velocity, sure = gap.motion.velocity[:, site.joint], gap.motion.sure_speed[:, site.joint]
        slower = self.shift(gap, site)[1]
        turned = 2.0 * direction(velocity - site.around * slower, sure)[0] - 1.0 - gap.forward(site.joint)
        return np.asarray(coulomb * turned / site.around - viscous * slower)

    def around_sites(self, gap: Gap, site: Site) -> list[Site]:
        """Compliances up to halfway to the neighbours on the grid."""
        return near_around(site, FINER_GIVE)

    def admissible(self, gap: Gap, site: Site, strengths: Floats) -> bool:
        """The compliance is near the one that the columns were computed for, and its effect exceeds the noise.

        At reversals no real machine's friction follows its law exactly, and a reversal a little earlier or later can
        make up for that.
        """
        if not (as_drawn(site, strengths) and super().admissible(gap, site, strengths)):
            return False
        effect = gap.rms((self.columns(gap, site)[site.joint] @ strengths), site.joint)
        return bool(effect > gap.noise_floor[site.joint])


class Swinging(_Elasticity):
    """The link oscillates on the compliance, at a resonance within the motion's band.

    The columns are computed around a compliance that is searched until the fitted strength agrees with it.
    """

    carries_friction = False
    curved = True
    ranked_alone = True
    promises = PROMISES

    def sites(self, gap: Gap) -> list[Site]:
        """Every examined joint, with resonances in the visible band that deflect it by less than the most."""
        out = []
        for joint in gap.examined:
            inertia = np.maximum(own_slopes(gap, joint)[2], LEAST_INERTIA)
            soft = [1.0 / (float(np.median(inertia)) * (2.0 * np.pi * frequency) ** 2) for frequency in RESONANCES]
            slow, most = gap.motion.cutoff * RESONANCE_BAND, float(np.max(np.abs(self.load(gap, joint))))
            able = [
                c for f, c in zip(RESONANCES, soft, strict=True) if f < slow and 0.0 < c * most < most_given(gap, joint)
            ]
            out += [Site(joint, (SCREENED_AT,), around=c) for c in able]
        return out

    def screening(self, gap: Gap, sites: Sequence[Site], every: int) -> Columns:
        """The torque at the joint itself, without the position filter."""
        return felt_by_itself(gap, sites, functools.partial(self._behind, rate=SCREENING_RATE), every)

    def _behind(self, gap: Gap, sites: Sequence[Site], rate: float = FLIGHT_RATE) -> Floats:
        # How far the link lags per unit of compliance, at many sites of one joint, (n, sites).
        joint, damped = sites[0].joint, np.array([site.shape[0] for site in sites])
        hardening = np.array([self.hardening(site) for site in sites])
        compliances = np.array([site.around for site in sites])
        load, effort = self.load(gap, joint), gap.known.effort
        given = given_along(gap.robot, without_offsets(gap.robot, gap.motion), joint)
        seen = None if given is None else in_motion(given - (effort.total[:, joint] - load), gap.motion, joint)
        link = lagging(gap, joint, load)._replace(seen=seen)
        damper = damper_of(link.inertia, compliances, damped)
        return np.asarray(swinging(gap.motion, link, 1.0 / compliances, damper, hardening, rate) / compliances)

    def shift(self, gap: Gap, site: Site) -> list[Floats]:
        """The link's lag through the position filter, and its two derivatives."""
        return smooth_derivatives(gap.motion, self._behind(gap, [site])[:, 0])

    def columns_of(self, gap: Gap, sites: Sequence[Site]) -> list[Columns]:
        """Links that lag on many springs are integrated in hardly more time than one."""
        return self.columns_behind(gap, sites, self._behind(gap, sites))

    def own_shape(self, gap: Gap, site: Site) -> bool:
        """A damping ratio below the largest one tried.

        A link damped that much does not oscillate; the cause may be, for example, a blow that a link gives its
        neighbours.
        """
        return site.shape[0] < DAMPINGS[-1]

    def admissible(self, gap: Gap, site: Site, strengths: Floats) -> bool:
        """The compliance is near the one that the columns were computed for, and admissible as any compliance; and it
        changes the joint's torque by more than the noise of its position does.

        A link that is soft enough takes no part in what is quick, noise of its acceleration included.
        """
        if not (as_drawn(site, strengths) and super().admissible(gap, site, strengths)):
            return False
        effect = gap.rms(self.columns(gap, site)[site.joint] @ strengths, site.joint)
        return bool(effect > noise_of_inertia(gap, site.joint))

    def extend(self, robot: Robot, site: Site, strengths: Floats) -> Robot:
        """Change the compliance, and let the link oscillate on it."""
        robot = super().extend(robot, site, strengths)
        own = robot.table.joint[site.joint].transmission
        swings = {"damping_ratio": site.shape[0], "hardening": own.hardening + self.hardening(site)}
        return changed(robot, site, transmission=own.model_copy(update=swings))

    def resonances(self, gap: Gap, site: Site, strengths: Floats) -> Floats:
        """Return the link's resonance frequency (Hz) about its usual deflection, in each pose of the motion, (n,)."""
        compliance = gap.robot.table.joint[site.joint].transmission.compliance + float(strengths[0])
        given, hardening = self.usually(gap, site, compliance), self.hardening(site)
        tangent = compliance / (1.0 + 3.0 * compliance * hardening * given**2)
        inertia = np.maximum(own_slopes(gap, site.joint)[2], LEAST_INERTIA)
        return np.asarray(natural_frequency(inertia, tangent) / (2.0 * np.pi))

    def usually(self, gap: Gap, site: Site, compliance: float) -> float:
        """Return how far the transmission gives under the RMS load."""
        load = float(np.sqrt(np.mean(np.square(self.load(gap, site.joint)))))
        return float(deflection(np.array([compliance * load]), compliance * self.hardening(site))[0])

    def evidence(self, gap: Gap, site: Site, strengths: Floats) -> str:
        """Give the deflection, and the resonance too."""
        usual = float(np.median(self.resonances(gap, site, strengths)))
        return f"{super().evidence(gap, site, strengths)}, and swings on it at about {usual:.3g} Hz"


@final
class SwingingElasticity(Swinging):
    """Its spring is straight."""

    shape_parameters = (DAMPING_RATIO,)

    def around_sites(self, gap: Gap, site: Site) -> list[Site]:
        """Compliances up to halfway to the neighbours on the grid, each with every damping ratio."""
        return [replace(site, around=c, shape=(damping,)) for c in _near_compliances(site) for damping in DAMPINGS]


@final
class HardeningElasticity(Swinging):
    """Its spring stiffens as it deflects, as those of harmonic drives do: its torque is s/compliance + hardening·s³."""

    shape_parameters = (DAMPING_RATIO, HARDENING)
    around_rounds = 12
    simpler = SwingingElasticity

    def hardening(self, site: Site) -> float:
        """The shape's."""
        return site.shape[1]

    def sites(self, gap: Gap) -> list[Site]:
        """Those of a straight spring, each with a few springs that are stiffer under the largest load."""
        straight, out = super().sites(gap), []
        most = {joint: float(np.max(np.abs(self.load(gap, joint)))) for joint in {site.joint for site in straight}}
        for site in straight:
            for stiffer in STIFFER:
                deflected = site.around * most[site.joint] / stiffer
                out.append(site.shaped((*site.shape, (stiffer - 1.0) / (site.around * deflected**2))))
        return out

    def around_sites(self, gap: Gap, site: Site) -> list[Site]:
        """Springs that are a little or much softer, more straight or more damped, one of the three at a time.

        A softer one hardens more, so that it gives alike under the usual load.
        """
        given, hardening = self.usually(gap, site, site.around), self.hardening(site)
        load, out = given / site.around + hardening * given**3, []
        for compliance in site.around * self._steps(FINER_RESONANCE):
            alike = max(load - given / compliance, LEAST_HARDENING * load) / given**3
            out.append(replace(site, around=float(compliance), shape=(site.shape[0], float(alike))))
        out += [site.shaped((site.shape[0], float(other))) for other in hardening * self._steps(FINER_HARDENING)]
        return out + [site.shaped((float(other), hardening)) for other in site.shape[0] * self._steps(FINER_DAMPING)]

    @staticmethod
    def _steps(largest: float) -> Floats:
        return np.power(largest, [-1.0, -0.25, 0.25, 1.0])
