"""What the pictures of a report need: a stated robot and a better one, held against the same rows of a log."""

from __future__ import annotations

from typing import Protocol

from mjfriction.identify.gap import Gap
from mjfriction.identify.joint_error import JointError
from mjfriction.record.log import Floats


class Compared(Protocol):
    """``gap`` is that of the stated robot, ``heldout`` (rows, joints) what the better one leaves on motion not fitted,
    ``joints`` both errors.
    """

    @property
    def gap(self) -> Gap:
        """The stated robot's gap."""
        ...

    @property
    def heldout(self) -> Floats:
        """What the better robot leaves."""
        ...

    @property
    def joints(self) -> tuple[JointError, ...]:
        """The errors of every examined joint."""
        ...
