"""body.gravity_direction: the base is tilted."""

from __future__ import annotations

from typing import final

import numpy as np

from mjfriction.body.regressor import gravity_torques
from mjfriction.diagnose.causes.cause import Quantity, Site
from mjfriction.diagnose.causes.whole_arm import WholeArm
from mjfriction.identify.gap import Gap
from mjfriction.parameter import Parameter
from mjfriction.record.log import Floats
from mjfriction.robot.robot import Robot

STEEPEST = 0.7  # largest component across the stated direction, relative to gravity


@final
class GravityDirection(WholeArm):
    """Gravity has a component across its stated direction: the base is tilted."""

    name = "body.gravity_direction"

    def sites(self, gap: Gap) -> list[Site]:
        """The whole arm, where there is gravity."""
        return self.felt_most(gap, Site(0)) if np.any(gap.body.gravity) else []

    def torques(self, gap: Gap) -> Floats:
        """Torques per m/s² along the two directions across gravity."""
        return gravity_torques(gap.body, gap.motion.position, _across(gap.body.gravity))

    def quantities(self, gap: Gap, site: Site) -> tuple[Quantity, ...]:
        """Gravity along the two directions across the stated one, where zero is stated."""
        words = [", ".join(f"{part:.3g}" for part in direction) for direction in _across(gap.body.gravity)]
        return tuple(
            Quantity(Parameter(f"gravity_across_{i}", "m/s²", f"gravity along ({word}) of the base"))
            for i, word in enumerate(words, start=1)
        )

    def admissible(self, gap: Gap, site: Site, strengths: Floats) -> bool:
        """Past some forty degrees it is another mounting, not a tilt."""
        return bool(np.linalg.norm(strengths) < STEEPEST * np.linalg.norm(gap.body.gravity))

    def extend(self, robot: Robot, site: Site, strengths: Floats) -> Robot:
        """Turn the robot's gravity, keeping its size."""
        stated = np.asarray(robot.body().gravity)
        size = float(np.linalg.norm(stated))
        across = np.asarray(strengths @ _across(stated))
        along = float(np.sqrt(max(size**2 - float(np.sum(np.square(across))), 0.0))) / size
        gravity = tuple((along * stated + across).tolist())
        return Robot(robot.table.model_copy(update={"gravity": gravity}), robot.folder)

    def evidence(self, gap: Gap, site: Site, strengths: Floats) -> str:
        """Give the angle."""
        angle = np.degrees(np.arcsin(min(1.0, float(np.linalg.norm(strengths) / np.linalg.norm(gap.body.gravity)))))
        return f"all joints feel gravity {angle:.3g} degrees off its stated direction: the base is tilted"


def _across(gravity: Floats) -> Floats:
    down = gravity / np.linalg.norm(gravity)
    seed = np.eye(3)[int(np.argmin(np.abs(down)))]
    first = seed - (seed @ down) * down
    first /= np.linalg.norm(first)
    return np.stack([first, np.cross(down, first)])
