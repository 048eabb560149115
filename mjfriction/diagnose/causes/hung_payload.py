"""body.payload: a mass held far out from the flange, where the motion shows its first moment alone."""

from __future__ import annotations

from typing import final

import numpy as np

from mjfriction.diagnose.causes.cause import Cause, Quantity, Site
from mjfriction.diagnose.causes.payload import HELD, Payload, torques_about
from mjfriction.identify.gap import Gap
from mjfriction.identify.regression import Columns
from mjfriction.parameter import Parameter
from mjfriction.record.log import Floats
from mjfriction.robot.robot import Robot

FAR_OUT = 0.3  # m; a payload's centre is hardly ever farther from the flange
STEP = 0.03  # m, of its centre, to compute how uncertain that is
CENTRE = tuple(Parameter(f"centre_{axis}", "m", f"its centre along {axis} of the flange") for axis in "xyz")


@final
class HungPayload(Cause):
    """A mass m at a given centre c from the flange, where none is stated, with the moments of inertia it has there."""

    name = "body.payload"
    whole_arm = True
    of_body = True
    covariate = "position"
    curved = True
    shape_parameters = CENTRE
    relative_shape = False

    def columns(self, gap: Gap, site: Site) -> Columns:
        """The effort at every examined joint, through the measurement chain."""

        def made() -> Columns:
            torques = torques_about(gap, np.array(site.shape)) @ np.append(1.0, site.shape)
            return {joint: gap.reported(joint, torques[:, [joint]]) for joint in gap.examined}

        return gap.kept.recall(f"{type(self).__name__} {site.shape}", made)

    def shape_steps(self, gap: Gap, site: Site) -> tuple[float, ...]:
        """A few centimetres."""
        return (STEP,) * len(CENTRE)

    def quantities(self, gap: Gap, site: Site) -> tuple[Quantity, ...]:
        """Its mass."""
        return (Quantity(HELD[0]),)

    def admissible(self, gap: Gap, site: Site, strengths: Floats) -> bool:
        """As any payload."""
        return Payload().admissible(gap, site, _with_moment(site, strengths))

    def noteworthy(self, gap: Gap, site: Site, strengths: Floats) -> bool:
        """As any payload."""
        return Payload().noteworthy(gap, site, _with_moment(site, strengths))

    def usual(self, gap: Gap, site: Site, strengths: Floats) -> bool:
        """As any payload."""
        return Payload().usual(gap, site, _with_moment(site, strengths))

    def extend(self, robot: Robot, site: Site, strengths: Floats) -> Robot:
        """State it."""
        return Payload().extend(robot, site, _with_moment(site, strengths))

    def evidence(self, gap: Gap, site: Site, strengths: Floats) -> str:
        """Give mass and centre."""
        return Payload().evidence(gap, site, _with_moment(site, strengths))


def _with_moment(site: Site, strengths: Floats) -> Floats:
    # The mass and its first moment, (4,).
    return np.asarray(strengths[0] * np.array([1.0, *site.shape]))
