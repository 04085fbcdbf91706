"""What every test may use."""

import numpy as np
import pytest
from hypothesis import settings

# The same examples in every run: a failure is then a change's, and shows again.
settings.register_profile("repeatable", derandomize=True, deadline=None)
settings.load_profile("repeatable")


@pytest.fixture
def rng():
    """The same random numbers for every run of a test."""
    return np.random.default_rng(20260)
