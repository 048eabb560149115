"""What puts a link elsewhere than its sensor says: a zero that is off (sensor.encoder_offset), a transmission that
gives (drive.elasticity) or that has play (drive.backlash).
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import ClassVar, final

import numpy as np

from mjfriction.diagnose.causes.cause import Cause, Quantity, Site, column, near_around
from mjfriction.identify.gap import Gap
from mjfriction.identify.regression import Columns
from mjfriction.parameter import Parameter
from mjfriction.record.log import Floats
from mjfriction.record.motion import smooth_derivatives
from mjfriction.robot.robot import Robot
from mjfriction.robot.rubbing import wave_slopes_along
from mjfriction.robot.spring import spring_slope_along
from mjfriction.robot.transmission import LEAST_INERTIA, LOAD_BAND, coasting, swinging

OFFSET = Parameter("offset", "{length}", "what the sensor reads where the joint is at zero")
COMPLIANCE = Parameter("compliance", "{length}/{force}", "how far the transmission gives per load", lower=0.0)
DAMPING_RATIO = Parameter("damping_ratio", "1", "damping of the link on what gives, over the critical one", lower=0.0)
BACKLASH = Parameter("backlash", "{length}", "play of the transmission, from stop to stop", lower=0.0)
FARTHEST = 0.5  # rad or m that a zero may be off
PLAYS = tuple(6.4e-2 * 0.8**k for k in range(38))  # rad or m: from 64 mrad to 17 µm
FINER = 1.15  # half of a step of these
RESONANCES = tuple(2.5 * 1.1**k for k in range(25))  # Hz: from 2.5 to 25 Hz
RESONANCE_BAND = 0.3  # of the position filter's cutoff, below which a resonance shows
FINER_RESONANCE, NEIGHBOURS = 1.1, 5  # half of a step of these, as compliances, and what is tried within it
DAMPINGS = (0.025, 0.05, 0.1, 0.2)  # of critical
ROUNDS = 2  # in which a link's place in its play and what it needs there are found
NEAR = (0.6, 1.6)  # times the play that the columns were drawn for
WIDEST = 0.2  # rad or m of play or of give
FELT = 1e-6  # of the noise floor, below which a shift is felt by no joint


def load_on_link(gap: Gap, joint: int) -> Floats:
    """Return the load that a transmission carries along the stated motion, (n,): the link's, not the rotor's."""
    known = gap.known
    return np.asarray(known.effort.rigid[:, joint] - known.body.armature[joint] * gap.motion.acceleration[:, joint])


class _MovedLink(Cause):
    """The link is ``shift`` behind its sensor per unit strength; every joint feels what that changes in the torques."""

    covariate = "effort"

    @abstractmethod
    def shift(self, gap: Gap, site: Site) -> list[Floats]:
        """Return how far the sensor is ahead of the link, and its two derivatives, each (n,)."""

    def samples(self, gap: Gap, site: Site) -> Floats:
        """The torque at the joint itself, (n, 1)."""
        return column(self._torques(gap, site)[:, site.joint])

    def columns(self, gap: Gap, site: Site) -> Columns:
        """The torques at all joints that the shifted link changes, through the chain."""
        key = f"{type(self).__name__} {site.joint} {site.around} {site.shape}"
        if key not in gap.kept:
            torques = self._torques(gap, site)
            gap.kept[key] = {i: gap.reported(i, torques[:, [i]]) for i in gap.examined}
        return gap.kept[key]

    def sites(self, gap: Gap) -> list[Site]:
        """Every joint whose shift any examined joint would feel."""
        joints = [j for j in range(len(gap.robot.joints)) if j in gap.examined]
        return [
            Site(j)
            for j in joints
            if any(np.max(np.abs(c)) > self._felt(gap) for c in self.columns(gap, Site(j)).values())
        ]

    def _felt(self, gap: Gap) -> float:
        return FELT * float(np.sqrt(np.mean(np.square(np.nan_to_num(gap.measured)))))

    def _torques(self, gap: Gap, site: Site) -> Floats:
        out = np.zeros((gap.motion.time.size, len(gap.robot.joints)))
        for derivative, part in zip(gap.derivatives, self.shift(gap, site), strict=True):
            out -= derivative[:, :, site.joint] * part[:, None]
        return out


def _own(gap: Gap, joint: int) -> tuple[Floats, ...]:
    # How a joint's torque changes with its own position, velocity and acceleration, (n,) each.
    return tuple(derivative[:, joint, joint] for derivative in gap.derivatives)


def _felt_by_itself(gap: Gap, sites: Sequence[Site], behind: Callable[[Gap, Site], Floats], every: int) -> Columns:
    # What the joint itself feels of a link that is behind, without the position's filter, of each ``every``-th row.
    joint = sites[0].joint
    torques = np.empty((gap.motion.time.size, len(sites), 1))
    for k, site in enumerate(sites):
        parts = [behind(gap, site)]
        for _ in range(2):
            parts.append(gap.motion.differentiated(parts[-1]))
        torques[:, k, 0] = -sum(own * part for own, part in zip(_own(gap, joint), parts, strict=True))
    return {joint: gap.reported(joint, torques)[::every]}


def _changed(robot: Robot, site: Site, **changes: object) -> Robot:
    return robot.with_joint(robot.table.joint[site.joint].model_copy(update=changes))


@final
class EncoderOffset(_MovedLink):
    """The joint's zero is off: the sensor reads position + offset."""

    name = "sensor.encoder_offset"
    covariate = "position"
    curved = True
    of_body = True

    def shift(self, gap: Gap, site: Site) -> list[Floats]:
        """One, at rest."""
        one = np.ones_like(gap.motion.time)
        return [one, 0.0 * one, 0.0 * one]

    def _torques(self, gap: Gap, site: Site) -> Floats:
        # What goes along the stroke, springs and waves, stands elsewhere too; the motor is where its link is.
        out = super()._torques(gap, site)
        joint, position = gap.robot.table.joint[site.joint], gap.linked.position[:, site.joint]
        out[:, site.joint] -= spring_slope_along(joint.spring, position) + wave_slopes_along(joint.cogging, position)
        out[:, site.joint] -= gap.forward(site.joint) * wave_slopes_along(joint.friction_waves, position)
        return out

    def quantities(self, gap: Gap, site: Site) -> tuple[Quantity, ...]:
        """The offset, stated plus change."""
        return (Quantity(OFFSET, shift=gap.robot.table.joint[site.joint].position_sensor.offset),)

    def admissible(self, gap: Gap, site: Site, strengths: Floats) -> bool:
        """Half a radian or metre either way."""
        return bool(abs(strengths[0]) < FARTHEST)

    def extend(self, robot: Robot, site: Site, strengths: Floats) -> Robot:
        """Move the sensor's offset."""
        sensor = robot.table.joint[site.joint].position_sensor
        moved = sensor.model_copy(update={"offset": sensor.offset + float(strengths[0])})
        return _changed(robot, site, position_sensor=moved)

    def evidence(self, gap: Gap, site: Site, strengths: Floats) -> str:
        """Give the offset."""
        unit = "m" if gap.body.sliding[site.joint] else "rad"
        return (
            "gravity and inertia, as all joints feel them, are those of a pose in which the joint is "
            f"{-strengths[0]:+.4g} {unit} from where its sensor says"
        )


class _Elasticity(_MovedLink):
    """The transmission gives: the link lags its sensor by compliance · load."""

    name = "drive.elasticity"
    carries_friction: ClassVar[bool]

    def load(self, gap: Gap, joint: int) -> Floats:
        """Return what the transmission carries, (n,)."""
        load = load_on_link(gap, joint)
        return load + gap.known.effort.friction[:, joint] if self.carries_friction else load

    def shift(self, gap: Gap, site: Site) -> list[Floats]:
        """The load and its derivatives."""
        return smooth_derivatives(gap.motion, self.load(gap, site.joint), LOAD_BAND)

    def quantities(self, gap: Gap, site: Site) -> tuple[Quantity, ...]:
        """The compliance, stated plus change."""
        return (Quantity(COMPLIANCE, shift=gap.robot.table.joint[site.joint].transmission.compliance),)

    def admissible(self, gap: Gap, site: Site, strengths: Floats) -> bool:
        """It gives with the load, and by no more than a part of a turn."""
        stated = gap.robot.table.joint[site.joint].transmission.compliance
        most = float(np.max(np.abs(self.load(gap, site.joint))))
        return bool(stated + strengths[0] > 0.0 and strengths[0] * most < WIDEST)

    def extend(self, robot: Robot, site: Site, strengths: Floats) -> Robot:
        """Move the compliance."""
        own = robot.table.joint[site.joint].transmission
        compliance = max(0.0, own.compliance + float(strengths[0]))
        softer = own.model_copy(update={"compliance": compliance, "carries_friction": self.carries_friction})
        return _changed(robot, site, transmission=softer)

    def evidence(self, gap: Gap, site: Site, strengths: Floats) -> str:
        """Give how far it gives at the largest load."""
        sliding = gap.body.sliding[site.joint]
        most = float(np.max(np.abs(self.load(gap, site.joint))))
        return (
            f"the link lags its sensor in step with the load, by {strengths[0] * most:.3g} "
            f"{'m' if sliding else 'rad'} at {most:.3g} {'N' if sliding else 'N·m'}"
        )


@final
class Elasticity(_Elasticity):
    """Friction acts on the motor's side of what gives."""

    carries_friction = False


@final
class LinkSideElasticity(_Elasticity):
    """Friction acts on the link's side of what gives, and so belongs to the load."""

    carries_friction = True


@final
class SwingingElasticity(_Elasticity):
    """The link swings on what gives, at a resonance within the motion's band.

    The columns are drawn around a compliance that is searched until the strength agrees with it.
    """

    carries_friction = False
    curved = True
    shape_parameters = (DAMPING_RATIO,)

    def sites(self, gap: Gap) -> list[Site]:
        """Every joint, swinging at many frequencies."""
        out = []
        for joint in gap.examined:
            inertia = np.maximum(_own(gap, joint)[2], LEAST_INERTIA)
            soft = [1.0 / (float(np.median(inertia)) * (2.0 * np.pi * frequency) ** 2) for frequency in RESONANCES]
            slow = gap.motion.cutoff * RESONANCE_BAND
            out += [Site(joint, (DAMPINGS[1],), around=c) for f, c in zip(RESONANCES, soft, strict=True) if f < slow]
        return out

    def screening(self, gap: Gap, sites: Sequence[Site], every: int) -> Columns:
        """What the joint itself feels, without the position's filter."""
        return _felt_by_itself(gap, sites, self._behind, every)

    def _behind(self, gap: Gap, site: Site) -> Floats:
        # How far the link is behind per unit of compliance, (n,).
        load = self.load(gap, site.joint)
        stiffness, damping, inertia = _own(gap, site.joint)
        following = load
        for _ in range(ROUNDS):
            behind = swinging(gap.motion, following, inertia, site.around, site.shape[0])
            following = load - stiffness * behind - damping * gap.motion.differentiated(behind)
        return behind / site.around

    def shift(self, gap: Gap, site: Site) -> list[Floats]:
        """Where the link is, through the position's filter, and its derivatives."""
        return smooth_derivatives(gap.motion, self._behind(gap, site))

    def own_shape(self, gap: Gap, site: Site) -> bool:
        """What is damped as much as is tried does not swing: a blow, say, that a link gives its neighbours."""
        return site.shape[0] < DAMPINGS[-1]

    def around_sites(self, gap: Gap, site: Site) -> list[Site]:
        """To the neighbours on the grid, damped more and less."""
        near = np.geomspace(site.around / FINER_RESONANCE, site.around * FINER_RESONANCE, NEIGHBOURS)
        return [replace(site, around=float(c), shape=(damping,)) for c in near for damping in DAMPINGS]

    def admissible(self, gap: Gap, site: Site, strengths: Floats) -> bool:
        """It is near the compliance that the columns were drawn for."""
        near = NEAR[0] < strengths[0] / site.around < NEAR[1]
        return near and super().admissible(gap, site, strengths)

    def extend(self, robot: Robot, site: Site, strengths: Floats) -> Robot:
        """Move the compliance, and let the link swing on it."""
        robot = super().extend(robot, site, strengths)
        own = robot.table.joint[site.joint].transmission
        return _changed(robot, site, transmission=own.model_copy(update={"damping_ratio": site.shape[0]}))

    def evidence(self, gap: Gap, site: Site, strengths: Floats) -> str:
        """Give the resonance too."""
        inertia = float(np.median(_own(gap, site.joint)[2]))
        frequency = 1.0 / (2.0 * np.pi * np.sqrt(max(float(strengths[0]), 1e-300) * max(inertia, LEAST_INERTIA)))
        return f"{super().evidence(gap, site, strengths)}, and swings on it at about {frequency:.3g} Hz"


@final
class Backlash(_MovedLink):
    """The transmission has play: the link lags its sensor by half of it, towards the load.

    Crossed at once, it is linear in the play.  Crossed by the link's own inertia, it takes its time: the columns are
    drawn around a play that is searched until the strength agrees with it.  A play a fifth larger lands so much later
    that it explains nothing of the landing, so that many have to be tried.
    """

    name = "drive.backlash"
    curved = True

    def sites(self, gap: Gap) -> list[Site]:
        """Every joint, with many plays to coast across, and crossed at once.

        Where the load never changes its sign play is but an offset of the sensor, and nothing tells of how it would be
        crossed.
        """
        out = []
        for site in super().sites(gap):
            out += [replace(site, around=play) for play in PLAYS] + self._at_once(gap, site)
        return out

    def _at_once(self, gap: Gap, site: Site) -> list[Site]:
        return [replace(site, around=0.0)] if _crossings(gap, site.joint) else []

    def screening(self, gap: Gap, sites: Sequence[Site], every: int) -> Columns:
        """What the joint itself feels, without the position's filter: many plays, each for little."""
        return _felt_by_itself(gap, sites, self._behind, every)

    def _behind(self, gap: Gap, site: Site) -> Floats:
        # How far the link is behind per unit of play, (n,).
        load = load_on_link(gap, site.joint)
        if site.around == 0.0:
            return 0.5 * np.sign(load)
        stiffness, damping, inertia = _own(gap, site.joint)
        following = load
        for _ in range(ROUNDS):
            # What a link would need to follow the motor from where it is.
            behind = 0.5 * coasting(gap.motion, following, inertia, site.around)
            moved = stiffness * behind + damping * gap.motion.differentiated(behind)
            following = load - site.around * moved
        return behind

    def shift(self, gap: Gap, site: Site) -> list[Floats]:
        """Half the place of the link in its play, through the position's filter, and its derivatives."""
        return smooth_derivatives(gap.motion, self._behind(gap, site))

    def around_sites(self, gap: Gap, site: Site) -> list[Site]:
        """To the neighbours on the grid; and crossed at once."""
        return [*near_around(site, FINER), *self._at_once(gap, site)] if site.around else []

    def quantities(self, gap: Gap, site: Site) -> tuple[Quantity, ...]:
        """The play, stated plus change."""
        return (Quantity(BACKLASH, shift=gap.robot.table.joint[site.joint].transmission.backlash),)

    def admissible(self, gap: Gap, site: Site, strengths: Floats) -> bool:
        """There is no negative play, and none far from the one that the columns were drawn for."""
        near = site.around == 0.0 or NEAR[0] < strengths[0] / site.around < NEAR[1]
        return bool(near and 0.0 < gap.robot.table.joint[site.joint].transmission.backlash + strengths[0] < WIDEST)

    def extend(self, robot: Robot, site: Site, strengths: Floats) -> Robot:
        """Move the play."""
        own = robot.table.joint[site.joint].transmission
        play = max(0.0, own.backlash + float(strengths[0]))
        changed = own.model_copy(update={"backlash": play, "coasting": site.around != 0.0})
        return _changed(robot, site, transmission=changed)

    def evidence(self, gap: Gap, site: Site, strengths: Floats) -> str:
        """Give the play and how often it was crossed."""
        unit = "m" if gap.body.sliding[site.joint] else "rad"
        gap_found = f"the link lags its sensor by a gap of {strengths[0]:.3g} {unit} that the load"
        crossed = _crossings(gap, site.joint)
        return f"{gap_found} crossed {crossed} times" if crossed else f"{gap_found} never crossed"


def _crossings(gap: Gap, joint: int) -> int:
    # How often the load on a link changes its sign.
    return int(np.count_nonzero(np.diff(np.sign(load_on_link(gap, joint)))))
