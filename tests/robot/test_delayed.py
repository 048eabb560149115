"""What a drive reports late runs straight between samples and stays within its piece: held against numpy's interp."""

from __future__ import annotations

import functools
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from mjfriction.record.motion import Motion, estimate_motion
from mjfriction.record.readers import read_log
from mjfriction.robot.effort import delayed
from tests.hidden.machine import UR5_JOINTS, Machine, write_case


@functools.cache
def two_pieces() -> Motion:
    with tempfile.TemporaryDirectory() as folder:
        log, _ = write_case(Path(folder), Machine(), seed=1, seconds=6.0)
        motion = estimate_motion(read_log(log), UR5_JOINTS, 10.0)
    return replace(motion, piece=(np.arange(motion.time.size) > 400).astype(np.int64))


@settings(deadline=None)
@given(delay=st.floats(-3.0, 3.0), columns=st.sampled_from([(), (2,), (2, 3)]))
def test_it_is_what_was_there_so_much_earlier_in_its_piece(delay: float, columns: tuple[int, ...]) -> None:
    motion = two_pieces()
    course = np.random.default_rng(0).normal(size=(motion.time.size, *columns))
    late = delayed(course, motion, delay).reshape(motion.time.size, -1)
    for own in motion.pieces:
        for before, now in zip(course.reshape(motion.time.size, -1)[own].T, late[own].T, strict=True):
            np.testing.assert_allclose(now, np.interp(motion.time[own] - delay, motion.time[own], before), atol=1e-8)
