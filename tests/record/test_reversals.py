"""How far joints are from their last turn: a triangle wave has it in closed form."""

from __future__ import annotations

import numpy as np

from mjfriction.record.reversals import travel_since_turn


def test_travel_begins_anew_at_a_turn_and_with_each_piece() -> None:
    up, down = np.arange(10.0), np.arange(10.0)[::-1]
    position = np.concatenate([up, down, 100.0 + up, 100.0 + down])[:, None]
    velocity = np.repeat([1.0, -1.0, 1.0, -1.0], 10)[:, None]
    travel, known = travel_since_turn(velocity, position, [slice(0, 20), slice(20, 40)])
    np.testing.assert_array_equal(travel[:, 0], np.tile(np.concatenate([up, up]), 2))
    np.testing.assert_array_equal(known[:, 0], np.tile(np.repeat([False, True], 10), 2))
