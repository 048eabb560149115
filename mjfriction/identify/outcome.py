"""The outcome of an identification, as plain data."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from mjfriction.identify.fit import LawFit
from mjfriction.identify.fitted import Fitted
from mjfriction.identify.friction_map import FrictionMap
from mjfriction.identify.gap import Gap
from mjfriction.identify.joint_error import JointError
from mjfriction.identify.map_fit import MapFit
from mjfriction.identify.pendulum import ByPendulum
from mjfriction.identify.refine import Refined
from mjfriction.record.log import Floats
from mjfriction.robot.robot import Robot


@dataclass(frozen=True)
class Candidate:
    """A law that was tried: the number of its parameters, and its held-out RMS error in the reported unit."""

    law: str
    parameters: int
    rms_heldout: float


@dataclass(frozen=True)
class JointLaw:
    """What was identified at a joint.

    ``how`` says what the values come from (such as "free motion" or "forward and backward passes").  ``structure`` is
    the largest share of the error that still follows a covariate, and ``follows`` names that covariate.  ``trusted``
    says whether the intervals can be trusted: not where structure is left, nor where friction still ``falls`` at the
    fastest speed.  ``passes`` are the joint's passes forward and backward, where the log has them, and ``by_slope`` is
    law (14) fitted to them by the manipulator paper's own procedure.  ``pendulum`` is the friction from each direction
    alone, which that paper compares with them.
    """

    joint: str
    fit: LawFit
    how: str
    parameters: tuple[Fitted, ...]
    candidates: tuple[Candidate, ...]
    structure: float
    follows: str
    trusted: bool
    falls: bool = False
    passes: FrictionMap | None = None
    by_slope: MapFit | None = None
    pendulum: ByPendulum | None = None


@dataclass(frozen=True, repr=False)
class Identification:
    """The whole outcome of an identification.

    ``gap`` is that of the stated robot, ``robot`` the identified one, ``heldout`` (rows, joints) its held-out residual
    on the same rows.  ``background`` are the fitted values of links and offsets.  ``bandwidths`` (Hz, by joint) are
    those of drives that were found to low-pass their efforts; ``gap`` already includes them.  ``simulated`` is the
    refinement on simulated motion, where it was asked for.
    """

    gap: Gap
    robot: Robot
    joints: tuple[JointError, ...]
    laws: tuple[JointLaw, ...]
    background: tuple[Fitted, ...]
    heldout: Floats
    summary: str
    simulated: Refined | None = None
    bandwidths: Mapping[str, float] = field(default_factory=dict)

    def __repr__(self) -> str:
        """The summary sentence."""
        return f"<Identification: {self.summary}>"
