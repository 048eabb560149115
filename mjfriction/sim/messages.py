"""MuJoCo's own messages, which it prints and writes to a file in the working folder."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator

import mujoco


@contextlib.contextmanager
def messages_dropped() -> Iterator[None]:
    """Drop MuJoCo's warnings: the caller reads MuJoCo's warning counts and reports what a user needs."""
    before = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(lambda _: None)
    try:
        yield
    finally:
        mujoco.set_mju_user_warning(before)
