"""What puts a link elsewhere than its sensor says: a zero that is off (sensor.encoder_offset), a transmission that
gives (drive.elasticity) or that has play (drive.backlash).
"""

from __future__ import annotations

from abc import abstractmethod
from typing import final

import numpy as np

from mjfriction.diagnose.causes.cause import Cause, Quantity, Site, column
from mjfriction.diagnose.gap import Gap
from mjfriction.diagnose.regression import Columns
from mjfriction.parameter import Parameter
from mjfriction.record.log import Floats
from mjfriction.record.motion import smooth_derivatives
from mjfriction.robot.robot import Robot
from mjfriction.robot.schema import Joint

OFFSET = Parameter("offset", "{length}", "what the sensor reads where the joint is at zero")
COMPLIANCE = Parameter("compliance", "{length}/{force}", "how far the transmission gives per load", lower=0.0)
BACKLASH = Parameter("backlash", "{length}", "play of the transmission, from stop to stop", lower=0.0)
FARTHEST = 0.5  # rad or m that a zero may be off
WIDEST = 0.2  # rad or m of play or of give
FELT = 1e-6  # of the noise floor, below which a shift is felt by no joint


def load_on_link(gap: Gap, joint: int) -> Floats:
    """Return the load that a transmission carries along the stated motion, (n,): the link's, not the rotor's."""
    return np.asarray(gap.effort.rigid[:, joint] - gap.body.armature[joint] * gap.motion.acceleration[:, joint])


class _MovedLink(Cause):
    """The link is ``shift`` behind its sensor per unit strength; every joint feels what that changes in the torques."""

    covariate = "effort"

    @abstractmethod
    def shift(self, gap: Gap, joint: int) -> list[Floats]:
        """Return how far the sensor is ahead of the link, and its two derivatives, each (n,)."""

    def samples(self, gap: Gap, site: Site) -> Floats:
        """The torque at the joint itself, (n, 1)."""
        return column(self._torques(gap, site.joint)[:, site.joint])

    def columns(self, gap: Gap, site: Site) -> Columns:
        """The torques at all joints that the shifted link changes, through the chain."""
        key = f"{self.name} {site.joint}"
        if key not in gap.kept:
            scale = [joint.effort_sensor.scale for joint in gap.robot.table.joint]
            rows = gap.chain.rows(self._torques(gap, site.joint))
            gap.kept[key] = {i: scale[i] * rows[:, [i]] for i in gap.examined}
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

    def _torques(self, gap: Gap, joint: int) -> Floats:
        out = np.zeros((gap.motion.time.size, len(gap.robot.joints)))
        for derivative, part in zip(gap.derivatives, self.shift(gap, joint), strict=True):
            out -= derivative[:, :, joint] * part[:, None]
        return out


def _changed(robot: Robot, joint: str, **changes: object) -> Robot:
    table: Joint = robot.joint(joint)
    return robot.with_joint(table.model_copy(update=changes))


@final
class EncoderOffset(_MovedLink):
    """The joint's zero is off: the sensor reads position + offset."""

    name = "sensor.encoder_offset"
    covariate = "position"
    curved = True

    def shift(self, gap: Gap, joint: int) -> list[Floats]:
        """One, at rest."""
        one = np.ones_like(gap.motion.time)
        return [one, 0.0 * one, 0.0 * one]

    def quantities(self, gap: Gap, site: Site) -> tuple[Quantity, ...]:
        """The offset, stated plus change."""
        return (Quantity(OFFSET, shift=gap.robot.table.joint[site.joint].position_sensor.offset),)

    def admissible(self, gap: Gap, site: Site, strengths: Floats) -> bool:
        """Half a radian or metre either way."""
        return bool(abs(strengths[0]) < FARTHEST)

    def extend(self, robot: Robot, site: Site, strengths: Floats) -> Robot:
        """Move the sensor's offset."""
        joint = robot.joints[site.joint]
        sensor = robot.joint(joint).position_sensor
        return _changed(
            robot, joint, position_sensor=sensor.model_copy(update={"offset": sensor.offset + float(strengths[0])})
        )

    def evidence(self, gap: Gap, site: Site, strengths: Floats) -> str:
        """Give the offset."""
        unit = "m" if gap.body.sliding[site.joint] else "rad"
        return (
            "gravity and inertia, as all joints feel them, are those of a pose in which the joint is "
            f"{-strengths[0]:+.4g} {unit} from where its sensor says"
        )


@final
class Elasticity(_MovedLink):
    """The transmission gives: the link lags its sensor by compliance · load."""

    name = "drive.elasticity"

    def shift(self, gap: Gap, joint: int) -> list[Floats]:
        """The load and its derivatives."""
        return smooth_derivatives(gap.motion, load_on_link(gap, joint))

    def quantities(self, gap: Gap, site: Site) -> tuple[Quantity, ...]:
        """The compliance, stated plus change."""
        return (Quantity(COMPLIANCE, shift=gap.robot.table.joint[site.joint].transmission.compliance),)

    def admissible(self, gap: Gap, site: Site, strengths: Floats) -> bool:
        """It gives with the load, and by no more than a part of a turn."""
        stated = gap.robot.table.joint[site.joint].transmission.compliance
        most = float(np.max(np.abs(load_on_link(gap, site.joint))))
        return bool(stated + strengths[0] > 0.0 and strengths[0] * most < WIDEST)

    def extend(self, robot: Robot, site: Site, strengths: Floats) -> Robot:
        """Move the compliance."""
        joint = robot.joints[site.joint]
        own = robot.joint(joint).transmission
        return _changed(
            robot,
            joint,
            transmission=own.model_copy(update={"compliance": max(0.0, own.compliance + float(strengths[0]))}),
        )

    def evidence(self, gap: Gap, site: Site, strengths: Floats) -> str:
        """Give how far it gives at the largest load."""
        sliding = gap.body.sliding[site.joint]
        most = float(np.max(np.abs(load_on_link(gap, site.joint))))
        return (
            f"the link lags its sensor in step with the load, by {strengths[0] * most:.3g} "
            f"{'m' if sliding else 'rad'} at {most:.3g} {'N' if sliding else 'N·m'}"
        )


@final
class Backlash(_MovedLink):
    """The transmission has play: the link lags its sensor by half of it, towards the load."""

    name = "drive.backlash"

    def sites(self, gap: Gap) -> list[Site]:
        """Joints whose load changes sign; elsewhere play is an offset of the sensor."""
        return [site for site in super().sites(gap) if np.ptp(np.sign(load_on_link(gap, site.joint))) > 0.0]

    def shift(self, gap: Gap, joint: int) -> list[Floats]:
        """Half the sign of the load, through the position's filter, and its derivatives."""
        return smooth_derivatives(gap.motion, 0.5 * np.sign(load_on_link(gap, joint)))

    def quantities(self, gap: Gap, site: Site) -> tuple[Quantity, ...]:
        """The play, stated plus change."""
        return (Quantity(BACKLASH, shift=gap.robot.table.joint[site.joint].transmission.backlash),)

    def admissible(self, gap: Gap, site: Site, strengths: Floats) -> bool:
        """There is no negative play."""
        return bool(0.0 < gap.robot.table.joint[site.joint].transmission.backlash + strengths[0] < WIDEST)

    def extend(self, robot: Robot, site: Site, strengths: Floats) -> Robot:
        """Move the play."""
        joint = robot.joints[site.joint]
        own = robot.joint(joint).transmission
        return _changed(
            robot, joint, transmission=own.model_copy(update={"backlash": max(0.0, own.backlash + float(strengths[0]))})
        )

    def evidence(self, gap: Gap, site: Site, strengths: Floats) -> str:
        """Give the play and how often it was crossed."""
        unit = "m" if gap.body.sliding[site.joint] else "rad"
        crossed = int(np.count_nonzero(np.diff(np.sign(load_on_link(gap, site.joint)))))
        return f"the link lags its sensor by a gap of {strengths[0]:.3g} {unit} that the load crossed {crossed} times"
