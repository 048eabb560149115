"""drive.backlash: base of the causes that differ in how the play of a transmission is crossed."""

from __future__ import annotations

from mjfriction.diagnose.causes.cause import Quantity, Site
from mjfriction.diagnose.causes.moved_link import WIDEST, MovedLink, changed
from mjfriction.identify.gap import Gap
from mjfriction.parameter import Parameter
from mjfriction.record.log import Floats
from mjfriction.robot.robot import Robot

BACKLASH = Parameter("backlash", "{length}", "play of the transmission, from stop to stop", lower=0.0)


class Play(MovedLink):
    """The transmission has play: the link lags its sensor by half of it, with the sign of the load."""

    name = "drive.backlash"
    brief = True

    def sites(self, gap: Gap) -> list[Site]:
        """Every joint whose shift any joint would feel, except where play was already seen in the position itself."""
        return [site for site in super().sites(gap) if site.joint not in gap.motion.jump_free]

    def quantities(self, gap: Gap, site: Site) -> tuple[Quantity, ...]:
        """The play, stated plus change."""
        return (Quantity(BACKLASH, shift=_stated(gap.robot, site)),)

    def admissible(self, gap: Gap, site: Site, strengths: Floats) -> bool:
        """The play is positive and below :data:`WIDEST`; it is no part of a turn."""
        return bool(0.0 < self.play(gap, site, strengths) < WIDEST)

    def play(self, gap: Gap, site: Site, strengths: Floats) -> float:
        """Return the play, stated plus change."""
        return _stated(gap.robot, site) + float(strengths[0])

    def played(self, robot: Robot, site: Site, strengths: Floats, **crossed: bool | float) -> Robot:
        """Return the robot with its play changed, and with how it is ``crossed``."""
        play = max(0.0, _stated(robot, site) + float(strengths[0]))
        own = robot.table.joint[site.joint].transmission
        return changed(robot, site, transmission=own.model_copy(update={"backlash": play, **crossed}))

    def gap_found(self, gap: Gap, site: Site, strengths: Floats) -> str:
        """Say how large the play is."""
        unit = "m" if gap.body.sliding[site.joint] else "rad"
        return f"the link lags its sensor by a gap of {strengths[0]:.3g} {unit}"


def _stated(robot: Robot, site: Site) -> float:
    return robot.table.joint[site.joint].transmission.backlash
