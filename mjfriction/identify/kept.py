"""Caches for what is costly to make and needed repeatedly."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Collection, Hashable
from typing import Generic, TypeVar

from mjfriction.identify.regression import Columns

Asked = TypeVar("Asked")
Made = TypeVar("Made")
# Numbers cached at a time, 320 MB.  Candidates are requested in the same order time and again.  All columns that seven
# joints are screened with, up to 37 million numbers, have to fit, or each column would be evicted before it is needed
# again.
MOST_NUMBERS = 40_000_000


class Kept:
    """Columns by their key; the least recently used ones make room for others."""

    def __init__(self) -> None:
        """Keep nothing yet."""
        self._columns: OrderedDict[Hashable, Columns] = OrderedDict()
        self._numbers = 0

    def apart_from(self, joints: Collection[int]) -> Kept:
        """Return a cache with only the columns that act on none of some joints."""
        out = Kept()
        out._columns.update({of: own for of, own in self._columns.items() if not set(own) & set(joints)})
        out._numbers = sum(_numbers(own) for own in out._columns.values())
        return out

    def recall(self, of: Hashable, make: Callable[[], Columns]) -> Columns:
        """Return the cached columns ``of`` something, or make them now; callers must not modify them."""
        if of in self._columns:
            self._columns.move_to_end(of)
            return self._columns[of]
        self._columns[of] = made = make()
        self._numbers += _numbers(made)
        while self._numbers > MOST_NUMBERS and len(self._columns) > 1:
            _, oldest = self._columns.popitem(last=False)
            self._numbers -= _numbers(oldest)
        return made


def _numbers(columns: Columns) -> int:
    return sum(values.size for values in columns.values())


class Lately(Generic[Asked, Made]):
    """The last few things that were made, by their keys: for keys that can be compared but not hashed."""

    def __init__(self, most: int) -> None:
        """Keep this many at most."""
        self._made: list[tuple[Asked, Made]] = []
        self._most = most

    def recall(self, of: Asked, make: Callable[[], Made]) -> Made:
        """Return what was recently made ``of`` an equal key, or make it now."""
        for known, made in self._made:
            if known == of:
                return made
        made = make()
        self._made.append((of, made))
        del self._made[: -self._most]
        return made
