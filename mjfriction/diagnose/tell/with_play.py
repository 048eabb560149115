"""The joints of a model that have play."""

from __future__ import annotations

from mjfriction.diagnose.causes.play import Play
from mjfriction.diagnose.fit.model import Model


def with_play(model: Model) -> set[int]:
    """Return the joints at which play is stated or was found."""
    stated = {i for i, joint in enumerate(model.gap.robot.table.joint) if joint.transmission.backlash > 0.0}
    return stated | {choice.site.joint for choice in model.chosen if isinstance(choice.cause, Play)}
