"""body.payload: base of the causes that a mass is held at the flange for a while, beyond what is stated."""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Sequence

import numpy as np

from mjfriction.body.regressor import tip_link
from mjfriction.diagnose.causes.cause import Quantity, Site
from mjfriction.diagnose.causes.payload import FARTHEST, Payload, stated_payload
from mjfriction.diagnose.causes.whole_arm import WholeArm
from mjfriction.identify.gap import Gap
from mjfriction.identify.regression import Columns
from mjfriction.parameter import Parameter
from mjfriction.record.log import Floats
from mjfriction.robot.body_tables import TakenUp
from mjfriction.robot.links_torque import is_held
from mjfriction.robot.robot import Robot

MOSTLY = 0.5  # fraction of the stated mass above which what is held counts as another payload, below as put down
NOTHING = 0.05  # fraction of the mass put down by which the remaining mass may be negative
BESIDES = (
    Parameter("mass", "kg", "mass held at the flange for a while, beyond that held throughout"),
    *(
        Parameter(f"moment_{axis}", "kg·m", f"its first moment along {axis} of the flange, beyond that")
        for axis in "xyz"
    ),
)


class HeldForAWhile(WholeArm):
    """A mass at the flange from one moment to another, more or less than is stated: m and its first moment m·c."""

    name = "body.payload"
    covariate = "time"
    times = 2  # e.g. another payload in several logs, and yet another in one of them

    @abstractmethod
    def span(self, site: Site) -> tuple[float, float]:
        """Return from when until when it is held, s on the log's clock."""

    def torques(self, gap: Gap) -> Floats:
        """Torques per mass and first moment, as if held throughout."""
        return Payload().torques(gap)

    def columns(self, gap: Gap, site: Site) -> Columns:
        """The effort while it is held; no filter leaks beyond that."""
        held = is_held(*self.span(site), gap.chain.time)
        return {joint: values * held[:, None] for joint, values in super().columns(gap, site).items()}

    def screening(self, gap: Gap, sites: Sequence[Site], every: int) -> Columns:
        """The same, at many sites."""
        held = np.column_stack([is_held(*self.span(site), gap.chain.time[::every]) for site in sites])
        whole = super().columns(gap, sites[0])
        return {joint: held[:, :, None] * values[::every, None, :] for joint, values in whole.items()}

    def quantities(self, gap: Gap, site: Site) -> tuple[Quantity, ...]:
        """Mass and first moments beyond those held throughout."""
        return tuple(Quantity(parameter) for parameter in BESIDES)

    def admissible(self, gap: Gap, site: Site, strengths: Floats) -> bool:
        """The payload has mass, or nothing is left of the stated one, and its centre is near the flange."""
        mass, moment = stated_payload(gap.robot, gap.body)
        total, nothing = mass + strengths[0], NOTHING * abs(strengths[0])
        near = np.linalg.norm(moment + strengths[1:]) < FARTHEST * max(total, nothing)
        return bool(total >= -nothing and near)

    def noteworthy(self, gap: Gap, site: Site, strengths: Floats) -> bool:
        """As for a payload that is held throughout."""
        return Payload().noteworthy(gap, site, strengths)

    def extend(self, robot: Robot, site: Site, strengths: Floats) -> Robot:
        """Let the robot put down the stated payload meanwhile and take up another, or add the change alone."""
        body = robot.body()
        mass, moment = stated_payload(robot, body)
        change, total = float(strengths[0]), mass + float(strengths[0])
        if mass > 0.0 and total > MOSTLY * mass:
            held = [(-mass, moment / mass), (total, (moment + strengths[1:]) / total)]
        else:  # nothing is stated, or too little of it is left to have a definite centre
            held = [(change, strengths[1:] / change)]
        begin, end = self.span(site)
        loads = [
            TakenUp(
                mass=own,
                com=(float(centre[0]), float(centre[1]), float(centre[2])),
                parent=tip_link(body),
                begin=begin,
                end=None if math.isinf(end) else end,
            )
            for own, centre in held
        ]
        return Robot(robot.table.model_copy(update={"taken_up": (*robot.table.taken_up, *loads)}), robot.folder)

    def evidence(self, gap: Gap, site: Site, strengths: Floats) -> str:
        """Say when, and give what differs then."""
        moment = ", ".join(f"{value:+.3g}" for value in strengths[1:])
        return (
            f"{self.when(gap, site)} alone all joints need what {strengths[0]:+.3g} kg at the flange need besides, "
            f"with a first moment of ({moment}) kg·m about {tip_link(gap.body)}: what it held there is another payload"
        )

    @abstractmethod
    def when(self, gap: Gap, site: Site) -> str:
        """Say when it is held."""
