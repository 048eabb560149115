"""body.payload: a mass at the flange in some of several logs only."""

from __future__ import annotations

import math
from typing import final

from mjfriction.diagnose.causes.cause import Site
from mjfriction.diagnose.causes.held_for_a_while import HeldForAWhile
from mjfriction.diagnose.causes.payload import held_elsewhere
from mjfriction.identify.gap import Gap


@final
class PayloadForAWhile(HeldForAWhile):
    """A mass at the flange in some of several logs only, more or less than is stated."""

    first_order = 1

    def sites(self, gap: Gap) -> list[Site]:
        """From each log on, up to each log, and in each log alone, unless a payload is stated on another link."""
        spans = [span for _, span in gap.log.logs]
        if len(spans) < 2 or held_elsewhere(gap):
            return []
        first = spans[0][0]
        whiles = {(first, end) for _, end in spans} | {(begin, math.inf) for begin, _ in spans} | set(spans)
        whiles.remove((first, math.inf))
        return [own for begin, end in sorted(whiles) for own in self.felt_most(gap, Site(0, begin=begin, end=end))]

    def span(self, site: Site) -> tuple[float, float]:
        """From the beginning of a log to the end of one."""
        return site.begin, site.end

    def when(self, gap: Gap, site: Site) -> str:
        """Name the logs."""
        return f"in {' and '.join(name for name, begin in gap.log.joined if site.begin <= begin < site.end)}"
