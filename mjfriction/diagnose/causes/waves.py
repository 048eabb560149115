"""Effects that repeat along the stroke: cogging (drive.cogging), and friction that varies with position
(friction.position).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar, final

import numpy as np

from mjfriction.diagnose.causes.cause import JointCause, Quantity, Site
from mjfriction.identify.gap import Gap
from mjfriction.identify.regression import Columns
from mjfriction.identify.stroke_waves import (
    STEPS_PER_LOBE,
    wavenumber_bounds,
    wavenumber_step,
    wavenumbers,
    waves_at_rows,
)
from mjfriction.parameter import Parameter
from mjfriction.record.log import Floats
from mjfriction.robot.friction import with_friction_wave
from mjfriction.robot.robot import Robot
from mjfriction.robot.schema import Joint
from mjfriction.robot.table import Wave

WAVENUMBER = Parameter("wavenumber", "rad/{length}", "phase per position; 2π over the period", lower=1e-6)
COSINE = Parameter("cosine", "{force}", "amplitude of the cosine of wavenumber times position")
SINE = Parameter("sine", "{force}", "amplitude of the sine of wavenumber times position")


class _Waves(JointCause):
    """Cosine and sine of a searched wavenumber, as a torque of their own or times the direction of motion."""

    shape_parameters = (WAVENUMBER,)
    covariate = "position"
    of_unevenness = True
    turns: ClassVar[bool] = False  # whether the waves change sign with the direction of motion

    def sites(self, gap: Gap) -> list[Site]:
        """Every examined joint, with wavenumbers as close as its stroke can resolve."""
        own = {site: wavenumbers(gap, site.joint, turns=self.turns) for site in super().sites(gap)}
        return [Site(site.joint, (k,)) for site, numbers in own.items() for k in numbers.tolist()]

    def chances(self, sites: Sequence[Site]) -> int:
        """The number of wavenumbers that differ by a whole period over the stroke."""
        return int(np.ceil(len(sites) / STEPS_PER_LOBE))

    def shape_bounds(self, gap: Gap, site: Site) -> list[tuple[float, float]]:
        """The wavenumbers that the motion can show."""
        return [wavenumber_bounds(gap, site.joint, turns=self.turns)]

    def shape_steps(self, gap: Gap, site: Site) -> tuple[float, ...]:
        """A third of the grid's step, so that the search stays on the peak it starts from."""
        return (wavenumber_step(gap, site.joint) / 3.0,)

    def apart(self, gap: Gap, site: Site, other: Site) -> bool:
        """Two waves within one step of the grid are one, fitted twice with large amplitudes that cancel."""
        waves = len(site.shape) == len(other.shape)  # a spot along the stroke, with two shape parameters, is no wave
        return not waves or bool(abs(site.shape[0] - other.shape[0]) > wavenumber_step(gap, site.joint))

    def samples(self, gap: Gap, site: Site) -> Floats:
        """The two waves, (n, 2)."""
        phase = site.shape[0] * gap.motion.position[:, site.joint]
        forward = gap.forward(site.joint)[:, None] if self.turns else 1.0
        return np.asarray(np.column_stack([np.cos(phase), np.sin(phase)]) * forward)

    def screening(self, gap: Gap, sites: Sequence[Site], every: int) -> Columns:
        """The waves at the rows, attenuated as the chain does at their frequency there, so that no filter is needed."""
        joint = sites[0].joint
        wavenumber = np.array([site.shape[0] for site in sites])
        return {joint: waves_at_rows(gap, joint, wavenumber, every, turns=self.turns)}

    def quantities(self, gap: Gap, site: Site) -> tuple[Quantity, ...]:
        """The two amplitudes."""
        return (Quantity(COSINE), Quantity(SINE))


def as_stated(table: Joint, wavenumber: float, read: complex) -> Wave:
    """Return a wave over a joint's sensor reading as a robot file states it, over the joint's position.

    The real and imaginary part of ``read`` are the amplitudes of its cosine and sine over the reading.
    """
    there = read * np.exp(-1j * wavenumber * table.position_sensor.offset)
    return Wave(wavenumber=wavenumber, cosine=float(there.real), sine=float(there.imag))


def _period(gap: Gap, site: Site) -> str:
    sliding = gap.body.sliding[site.joint]
    period = 2.0 * np.pi / site.shape[0]
    return f"{period:.4g} m" if sliding else f"{period:.4g} rad ({site.shape[0]:.4g} to a turn)"


@final
class Cogging(_Waves):
    """C·cos(k q) + S·sin(k q), in whichever direction the joint moves."""

    name = "drive.cogging"
    picture = "spectrum"
    times = 3  # a motor's cogging has harmonics

    def extend(self, robot: Robot, site: Site, strengths: Floats) -> Robot:
        """Add a wave to the joint's cogging."""
        joint = robot.joints[site.joint]
        table = robot.joint(joint)
        wave = as_stated(table, site.shape[0], complex(*strengths))
        return robot.with_joint(table.model_copy(update={"cogging": (*table.cogging, wave)}))

    def evidence(self, gap: Gap, site: Site, strengths: Floats) -> str:
        """Give amplitude and period."""
        unit = "N" if gap.body.sliding[site.joint] else "N·m"
        return (
            f"a torque of {np.hypot(*strengths):.3g} {unit} repeats every {_period(gap, site)} of position and does "
            "not turn with the direction of motion"
        )


@final
class PositionFriction(_Waves):
    """(C·cos(k q) + S·sin(k q))·sgn v."""

    name = "friction.position"
    picture = "turned_spectrum"
    least_of_friction = 0.05  # no machine's friction is more even than that along its stroke
    times = 2
    turns = True

    def extend(self, robot: Robot, site: Site, strengths: Floats) -> Robot:
        """Add a wave to the joint's friction level."""
        name = robot.joints[site.joint]
        return with_friction_wave(robot, name, as_stated(robot.joint(name), site.shape[0], complex(*strengths)))

    def evidence(self, gap: Gap, site: Site, strengths: Floats) -> str:
        """Give amplitude and period."""
        unit = "N" if gap.body.sliding[site.joint] else "N·m"
        return (
            f"the friction level rises and falls by {np.hypot(*strengths):.3g} {unit} every {_period(gap, site)} of "
            "position, against the motion in both directions"
        )
