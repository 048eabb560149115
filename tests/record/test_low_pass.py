"""The low-pass that goes to and fro, against SciPy's own."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import sosfiltfilt

from mjfriction.record.low_pass import butterworth


@pytest.mark.parametrize(("order", "band"), [(2, 3.0), (4, 30.0)])
def test_to_and_fro_is_scipys_without_padding(order: int, band: float) -> None:
    values = np.cumsum(np.random.default_rng(0).standard_normal(2000)) + 7.0
    slow = butterworth(order, band, 250.0)
    own, theirs = slow.to_and_fro(values), sosfiltfilt(slow.sections, values, padlen=0)
    np.testing.assert_allclose(own, theirs, rtol=0.0, atol=1e-10 * np.ptp(values))


def test_what_rests_rests() -> None:
    np.testing.assert_allclose(butterworth(4, 10.0, 250.0).to_and_fro(np.full(300, 3.2)), 3.2, rtol=1e-10)
