"""body.payload: a mass that is taken up, or put down, while a log is recorded."""

from __future__ import annotations

import math
from typing import final

import numpy as np

from mjfriction.diagnose.causes.cause import Site
from mjfriction.diagnose.causes.held_for_a_while import HeldForAWhile
from mjfriction.diagnose.causes.payload import held_elsewhere
from mjfriction.identify.gap import Gap
from mjfriction.parameter import Parameter
from mjfriction.record.fault import moment
from mjfriction.record.log import Floats

TAKEN_UP = Parameter("begin", "s", "moment at which it is taken up, on the log's clock")
PUT_DOWN = Parameter("end", "s", "moment at which it is put down, on the log's clock")
PARTS = 12  # parts of a log, at whose edges it may be taken up and put down before the moments are searched
EDGE = 0.25  # fraction of such a part: the least time that it is held, or not held at the log's beginning or end


@final
class CarriedPayload(HeldForAWhile):
    """A mass at the flange during a part of one log."""

    first_order = 3
    shape_parameters = (TAKEN_UP, PUT_DOWN)
    relative_shape = False

    def sites(self, gap: Gap) -> list[Site]:
        """From the beginning of each part of a log to the end of any, but not of the whole; of one log only."""
        if len(gap.log.logs) > 1 or held_elsewhere(gap):
            return []
        time = gap.motion.time
        edges = np.linspace(float(time[0]), float(time[-1]), PARTS + 1).tolist()
        pairs = [(edges[i], edges[j]) for i in range(PARTS) for j in range(i + 1, PARTS + 1) if j - i < PARTS]
        whole = self.felt_most(gap, Site(0, (edges[0], edges[-1]), begin=edges[0], end=edges[-1]))
        return [site.shaped(pair) for site in whole for pair in pairs]

    def span(self, site: Site) -> tuple[float, float]:
        """From when it is taken up, or the log's beginning, until it is put down, or the log's end and on."""
        begin, end = site.shape
        near = _least(site)
        return site.begin if begin < site.begin + near else begin, math.inf if end > site.end - near else end

    def shape_bounds(self, gap: Gap, site: Site) -> list[tuple[float, float]]:
        """Within the log."""
        return [(site.begin, site.end)] * 2

    def shape_steps(self, gap: Gap, site: Site) -> tuple[float, ...]:
        """Half of a part, inwards at the log's end."""
        half = 0.5 * (site.end - site.begin) / PARTS
        return half, -half if site.shape[1] + half > site.end else half

    def own_shape(self, gap: Gap, site: Site) -> bool:
        """It is taken up or put down in the log."""
        begin, end = self.span(site)
        return begin > site.begin or math.isfinite(end)

    def shape_resolution(self, gap: Gap, site: Site) -> tuple[float, ...]:
        """The time from row to row."""
        return (gap.chain.step,) * 2

    def admissible(self, gap: Gap, site: Site, strengths: Floats) -> bool:
        """It is also held for longer than a moment."""
        begin, end = site.shape
        return end - begin > _least(site) and super().admissible(gap, site, strengths)

    def when(self, gap: Gap, site: Site) -> str:
        """Give the moments."""
        begin, end = self.span(site)
        until = "on" if math.isinf(end) else f"to {moment(end)} s"
        return f"from {moment(begin)} s {until}"


def _least(site: Site) -> float:
    return EDGE * (site.end - site.begin) / PARTS
