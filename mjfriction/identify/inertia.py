"""The links' inertial parameters, refitted together with friction.

Each link gets a scale of its mass and inertia and a shift of its centre of mass, held near what is stated by how far
stated values usually are off.

Of the ten parameters of a link only combinations show in the efforts; what the data do not fix stays as stated.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mjfriction.body.regressor import first_moment_torques
from mjfriction.identify.gap import Gap
from mjfriction.identify.regression import Columns
from mjfriction.record.log import Floats
from mjfriction.robot.robot import Robot

USUAL_SCALE = 0.10  # one standard deviation of how far a stated mass and inertia are off
USUAL_SHIFT = 0.02  # m, and a stated centre of mass
FELT = 1e-6  # of the effort, below which a link is not felt
SMALLEST, LARGEST = -0.9, 9.0  # change of a mass that a link can have


@dataclass(frozen=True)
class LinkColumns:
    """Efforts per unit of a link's scale and of its shifts along x, y and z (m), at every examined joint."""

    name: str
    columns: Columns

    @property
    def precision(self) -> Floats:
        """One over the variance known beforehand of the four strengths."""
        return np.array([USUAL_SCALE**-2.0, *[USUAL_SHIFT**-2.0] * 3])


def link_columns(gap: Gap) -> list[LinkColumns]:
    """Return the columns of every link that is felt."""
    linked = gap.linked
    shifts = first_moment_torques(gap.body, linked.position, linked.velocity, linked.acceleration)
    size = float(np.sqrt(np.mean(np.square(np.nan_to_num(gap.measured)))))
    out = []
    for k, name in enumerate(gap.body.links):
        block = {}
        for joint in gap.examined:
            scale = gap.robot.table.joint[joint].effort_sensor.scale
            samples = np.column_stack([gap.link_torques[:, joint, k], shifts[:, joint, k]])
            block[joint] = scale * gap.chain.rows(samples)
        if any(np.max(np.abs(columns)) > FELT * size for columns in block.values()):
            out.append(LinkColumns(name, block))
    return out


def with_links(robot: Robot, links: list[LinkColumns], strengths: Floats) -> Robot:
    """Return the robot with each link scaled and its centre moved by ``strengths`` (links, 4)."""
    scale, shift = dict(robot.table.link_scale), dict(robot.table.link_shift)
    for link, own in zip(links, strengths, strict=True):
        scale[link.name] = scale.get(link.name, 1.0) * (1.0 + float(np.clip(own[0], SMALLEST, LARGEST)))
        stated = shift.get(link.name, (0.0, 0.0, 0.0))
        x, y, z = (float(a + b) for a, b in zip(stated, own[1:], strict=True))
        shift[link.name] = (x, y, z)
    return Robot(robot.table.model_copy(update={"link_scale": scale, "link_shift": shift}), robot.folder)
