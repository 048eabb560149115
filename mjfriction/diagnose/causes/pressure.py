"""hydraulic.pressure: friction grows with the chambers' pressures, or with their difference at the piston's seal."""

from __future__ import annotations

from abc import abstractmethod
from typing import ClassVar, final

import numpy as np

from mjfriction.diagnose.causes.cause import SHIFTS, JointCause, Quantity, Site
from mjfriction.identify.gap import Gap
from mjfriction.laws.pressed_seals import PRESSED_SEALS
from mjfriction.record.log import HEAD_PRESSURE, ROD_PRESSURE, Floats
from mjfriction.robot.robot import Robot


class ChamberPressure(JointCause):
    """Friction under the pressures p(t) that the seals hold: Σ kᵢ·pᵢ·sgn v."""

    name = "hydraulic.pressure"
    covariate = "velocity"
    grows: ClassVar[tuple[str, ...]]
    """What grows with each pressure: the keys of a robot's ``pressure_friction``."""

    @abstractmethod
    def held(self, head: Floats, rod: Floats) -> tuple[Floats, ...]:
        """Return the pressures that the seals hold, (n,) each, from those of the chambers, (n,)."""

    def sites(self, gap: Gap) -> list[Site]:
        """Every examined joint whose chamber pressures were logged."""
        return [site for site in super().sites(gap) if all(p is not None for p in self._chambers(gap, site))]

    def _chambers(self, gap: Gap, site: Site) -> list[Floats | None]:
        joint = gap.robot.joints[site.joint]
        return [gap.motion.columns.get(f"{name}.{joint}") for name in (HEAD_PRESSURE, ROD_PRESSURE)]

    def samples(self, gap: Gap, site: Site) -> Floats:
        """The pressures times the direction of motion, (n, m)."""
        return gap.forward(site.joint)[:, None] * self.course(gap, site)

    def course(self, gap: Gap, site: Site) -> Floats:
        """Return the pressures that the seals hold along the log, (n, m)."""
        head, rod = map(np.asarray, self._chambers(gap, site))
        return np.column_stack(self.held(head, rod))

    def level_shifts(self, gap: Gap, site: Site, strengths: Floats) -> Floats:
        """At pressures sampled along the log."""
        pressures = self.course(gap, site)
        levels = pressures[:: max(1, pressures.shape[0] // SHIFTS)] @ strengths
        return np.column_stack([levels, np.zeros_like(levels)])

    def quantities(self, gap: Gap, site: Site) -> tuple[Quantity, ...]:
        """The growth of friction with each pressure, stated plus change."""
        stated = gap.robot.table.joint[site.joint].pressure_friction.model_dump()
        return tuple(Quantity(PRESSED_SEALS.parameter(name), shift=stated[name]) for name in self.grows)

    def extend(self, robot: Robot, site: Site, strengths: Floats) -> Robot:
        """Change the growth of the joint's friction with pressure."""
        joint = robot.joints[site.joint]
        table = robot.joint(joint)
        stated = table.pressure_friction.model_dump()
        changed = {name: stated[name] + change for name, change in zip(self.grows, strengths.tolist(), strict=True)}
        pressed = table.pressure_friction.model_copy(update=changed)
        return robot.with_joint(table.model_copy(update={"pressure_friction": pressed}))


@final
class Pressure(ChamberPressure):
    """(h·p₁ + r·p₂)·sgn v."""

    grows = ("head", "rod")

    def held(self, head: Floats, rod: Floats) -> tuple[Floats, ...]:
        """The pressure of each chamber."""
        return head, rod

    def evidence(self, gap: Gap, site: Site, strengths: Floats) -> str:
        """Give what ten bar add."""
        unit = "N" if gap.body.sliding[site.joint] else "N·m"
        head, rod = 1e6 * strengths
        return f"friction grows by {head:.3g} {unit} per 10 bar on the head's side and {rod:.3g} {unit} on the rod's"


@final
class PistonPressure(ChamberPressure):
    """d·|p₁ − p₂|·sgn v: the piston's seal lies between the chambers and is pressed by whichever of them is higher."""

    grows = ("difference",)

    def held(self, head: Floats, rod: Floats) -> tuple[Floats, ...]:
        """The absolute difference of the chambers' pressures."""
        return (np.abs(head - rod),)

    def evidence(self, gap: Gap, site: Site, strengths: Floats) -> str:
        """Give what ten bar add."""
        unit = "N" if gap.body.sliding[site.joint] else "N·m"
        return f"friction grows by {1e6 * strengths[0]:.3g} {unit} per 10 bar between the two chambers"
