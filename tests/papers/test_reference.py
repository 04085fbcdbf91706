"""J-PARSE against the authors' own package, where it is installed (extra `test`)."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from robust_ik.inverses import DampedLeastSquares, JParse, JParseWithGains, MoorePenrose
from tests.kinematics.test_svd import matrix

jparse_robotics = pytest.importorskip("jparse_robotics")
# The package uses numpy.matrix, which NumPy warns of.
pytestmark = pytest.mark.filterwarnings("ignore:the matrix subclass:PendingDeprecationWarning")

SHAPES = [(1, 1), (1, 4), (2, 2), (2, 3), (3, 3), (3, 7), (6, 6), (6, 7), (6, 10)]
SPECTRA = {
    "healthy": lambda k: np.linspace(2, 1, k),
    "one small": lambda k: np.concatenate([np.linspace(2, 1, k - 1), [0.03]]) if k > 1 else np.array([1.0]),
    "two small": lambda k: np.concatenate([np.linspace(3, 2, max(k - 2, 1)), [0.2, 0.01]])[:k],
    "graded": lambda k: 3.0 ** -np.arange(k),
}


def jacobians(rng):
    for m, n in SHAPES:
        for spectrum in SPECTRA.values():
            for _ in range(5):
                yield matrix(spectrum(min(m, n)), m, n, rng)


@pytest.mark.parametrize("gamma", [0.02, 0.1, 0.35])
def test_jparse_is_the_authors_jparse_on_jacobians_of_many_shapes(gamma, rng):
    reference = jparse_robotics.JParseCore(gamma=gamma)
    for J in jacobians(rng):
        assert_allclose(JParse(gamma).matrix(J), reference.compute(J), atol=1e-9)


def test_its_position_and_orientation_gains_are_the_authors(rng):
    reference = jparse_robotics.JParseCore(gamma=0.2)
    for J in jacobians(rng):
        if J.shape[0] != 6:
            continue
        theirs = reference.compute(
            J,
            singular_direction_gain_position=2.0,
            singular_direction_gain_angular=1.5,
            position_dimensions=3,
            angular_dimensions=3,
        )
        ours = JParseWithGains(gamma=0.2, position_gain=2.0, orientation_gain=1.5)
        xdot = rng.normal(size=6)
        assert_allclose(ours.solve(J, xdot), theirs @ xdot, atol=1e-9)


def test_its_baselines_are_ours_too(rng):
    reference = jparse_robotics.JParseCore()
    for J in jacobians(rng):
        assert_allclose(MoorePenrose().matrix(J), reference.pinv(J), atol=1e-9)
        assert_allclose(DampedLeastSquares(0.07).matrix(J), reference.damped_least_squares(J, damping=0.07), atol=1e-9)
