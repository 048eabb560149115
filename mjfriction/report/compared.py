"""What the pictures of a report need: a stated robot and a better one, compared on the same rows of a log."""

from __future__ import annotations

from typing import Protocol

from mjfriction.identify.gap import Gap
from mjfriction.identify.joint_error import JointError
from mjfriction.record.log import Floats


class Compared(Protocol):
    """The stated robot's ``gap``, the better robot's held-out residual ``heldout`` (rows, joints), and the errors of
    both at the ``joints``.
    """

    @property
    def gap(self) -> Gap:
        """The stated robot's gap."""
        ...

    @property
    def heldout(self) -> Floats:
        """The better robot's held-out residual, (rows, joints)."""
        ...

    @property
    def joints(self) -> tuple[JointError, ...]:
        """The errors of every examined joint."""
        ...
