"""Parameters of tests that only the heavier run tries."""

from __future__ import annotations

import pytest


def deep(*values: object) -> object:
    """Return values of a test's parameters that ``make deep`` tries, and ``make test`` does not."""
    return pytest.param(*values, marks=pytest.mark.deep)
