"""What one transmission brings in two ways is one finding: a drive that turns with two joints, and leans on the other.

The joint that such a drive leans on carries what the drive gives, so that its own drive reports that much less.
"""

from __future__ import annotations

from collections.abc import Iterable

from mjfriction.diagnose.causes.coupling import SharedDrive, SharedEffort
from mjfriction.diagnose.model import Chosen, Key


def parts_of_drives(chosen: Iterable[Chosen]) -> dict[Key, Chosen]:
    """Return those of causes that are shares of an effort between two joints of a drive that is shared, by that drive's
    key.
    """
    causes = list(chosen)
    shares = {_pair(one): one for one in causes if isinstance(one.cause, SharedEffort)}
    drives = {_pair(one): one for one in causes if isinstance(one.cause, SharedDrive)}
    return {drives[pair].key: share for pair, share in shares.items() if pair in drives}


def _pair(choice: Chosen) -> frozenset[int | None]:
    return frozenset((choice.site.joint, choice.site.other))
