"""What friction has in common that differs at a place of the stroke, or on one side of it (friction.position)."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from typing import ClassVar

import numpy as np

from mjfriction.diagnose.causes.cause import JointCause, Quantity, Site, column
from mjfriction.diagnose.causes.waves import PositionFriction
from mjfriction.identify.gap import Gap
from mjfriction.identify.regression import Columns
from mjfriction.parameter import Parameter
from mjfriction.record.log import Floats
from mjfriction.record.motion import Motion

HEIGHT = Parameter("coulomb", "{force}", "how much higher the friction level is there")
PASSES = 4  # least number of passes over a place, in both directions: fewer may show a chance event there
FLANK = 2.0  # widths from its place to where a spot or an edge is still felt
PLACES = 256  # number of positions along the stroke at which passes are counted


class FrictionAtPlace(JointCause):
    """C·height(q)·sgn v, with a height of a given form at a place and of a width, which are its shape."""

    name = PositionFriction.name
    relative_shape = False
    covariate = "position"
    picture = "turned"
    of_unevenness = True
    least_of_friction = PositionFriction.least_of_friction
    widths: ClassVar[tuple[float, ...]]  # widths to try, as fractions of the stroke
    width_range: ClassVar[tuple[float, float]]  # of the widths that are searched, as fractions of the stroke

    @abstractmethod
    def height(self, position: Floats, site: Site) -> Floats:
        """Return the height at positions (n,), at most 1."""

    @abstractmethod
    def spacing(self, width: float) -> float:
        """Return how far apart places are tried, for a width; both are fractions of the stroke."""

    def sites(self, gap: Gap) -> list[Site]:
        """Every examined joint, with a few widths and places, where the joint passes often."""
        out = []
        for site in super().sites(gap):
            position = gap.motion.position[:, site.joint]
            low, stroke = float(np.min(position)), float(np.ptp(position))
            for width in self.widths:
                step = self.spacing(width) * stroke
                places = np.arange(low, low + stroke + 0.5 * step, step).tolist()
                shaped = [Site(site.joint, (place, width * stroke)) for place in places]
                out += [own for own in shaped if self.own_shape(gap, own)]
        return out

    def shape_bounds(self, gap: Gap, site: Site) -> list[tuple[float, float]]:
        """A place of which the joint often passes a flank at least, and a width that is a fraction of the stroke."""
        often, stroke = _places(gap, site.joint), float(np.ptp(gap.motion.position[:, site.joint]))
        least, most = (share * stroke for share in self.width_range)
        return [(float(np.min(often)) - FLANK * most, float(np.max(often)) + FLANK * most), (least, most)]

    def shape_steps(self, gap: Gap, site: Site) -> tuple[float, ...]:
        """A third of the distance of the places that are tried, and of the width."""
        stroke, width = float(np.ptp(gap.motion.position[:, site.joint])), site.shape[1]
        return (self.spacing(width / stroke) * stroke / 3.0, width / 3.0)

    def own_shape(self, gap: Gap, site: Site) -> bool:
        """A place that is within two widths of one that the joint passes often, in both directions."""
        often, (place, width) = _places(gap, site.joint), site.shape
        return bool(often.size and np.min(np.abs(often - place)) <= FLANK * width)

    def apart(self, gap: Gap, site: Site, other: Site) -> bool:
        """It can be told from a wave, but not from another cause with as many shape parameters."""
        return len(other.shape) != len(site.shape)

    def samples(self, gap: Gap, site: Site) -> Floats:
        """The height times the direction of motion, (n, 1)."""
        return column(self.height(gap.motion.position[:, site.joint], site) * gap.forward(site.joint))

    def screening(self, gap: Gap, sites: Sequence[Site], every: int) -> Columns:
        """The heights at the rows, without filtering.

        In the filtered rows, a place that is passed in less than one row is really lower and wider.
        """
        joint = sites[0].joint
        position, forward = (gap.at_rows(name)[::every, joint] for name in ("position", "forward"))
        return {joint: np.stack([column(self.height(position, site) * forward) for site in sites], axis=1)}

    def quantities(self, gap: Gap, site: Site) -> tuple[Quantity, ...]:
        """How much higher the level is."""
        return (Quantity(HEIGHT),)


def _places(gap: Gap, joint: int) -> Floats:
    return gap.kept.recall(f"places passed {joint}", lambda: {joint: _often(gap.motion, joint)})[joint]


def _often(motion: Motion, joint: int) -> Floats:
    # The positions along its stroke that a joint passes often enough, and in both directions.
    position, joined = motion.position[:, joint], np.diff(motion.piece) == 0
    places = np.linspace(np.min(position), np.max(position), PLACES)
    before, after = (np.searchsorted(places, own[joined]) for own in (position[:-1], position[1:]))
    ways = []
    for low, high in ((before, after), (after, before)):
        ahead = low < high
        count = np.zeros(PLACES + 1, dtype=np.int64)
        np.add.at(count, low[ahead], 1)
        np.add.at(count, high[ahead], -1)
        ways.append(np.cumsum(count)[:-1])
    return np.asarray(places[(ways[0] + ways[1] >= PASSES) & (ways[0] > 0) & (ways[1] > 0)])
