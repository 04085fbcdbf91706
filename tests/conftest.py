"""What every test may use."""

import numpy as np
import pytest


@pytest.fixture
def rng():
    """The same random numbers for every run of a test."""
    return np.random.default_rng(20260)
