"""Checks the rank that an arm is said to have nearly everywhere, of which its coranks are what is missing.

At any point modulo any prime the rank is at most that of the arm: a larger one than stated refutes the statement, and
one as large shows that it is attained. That it is not larger is shown as identities are: if it were, some minor would
not be zero as a polynomial, and would be zero at a random point modulo a random prime with a chance below 1e-15.
"""

from __future__ import annotations

import random

from robust_ik.certificates.checker.expected_children import require
from robust_ik.certificates.checker.modular_arithmetic import UnluckyError, random_prime, rank
from robust_ik.certificates.checker.modular_kinematics import ModularReplay, random_point
from robust_ik.certificates.checker.modular_rings import Ring
from robust_ik.certificates.proof.case_tree import RATIONAL
from robust_ik.certificates.proof.proof_arm import Arm

TRIES = 5
"""Most points: by chance the rank at one of them is too small, or cannot be worked out, once in about 2⁵⁰."""


def check_rank(arm: Arm, rng: random.Random) -> None:
    """Checks that the rank of the Jacobian at random points, over random prime fields, is the arm's and no larger."""
    found = -1
    for _ in range(TRIES):
        prime = random_prime(rng)
        point = {joint: random_point(joint, arm, rng, prime) for joint in range(len(arm.joints))}
        try:
            found = max(found, rank(ModularReplay(arm, 0, Ring(prime, RATIONAL)).jacobian(point), prime))
        except UnluckyError:
            continue
        if found >= arm.rank:
            break
    require(found == arm.rank, f"the rank of its arm is {found} nearly everywhere, not {arm.rank}")
