"""Results that a case split works out again and again, kept with the steps that they took.

Cases differ by a pin or a relation, so most of their forms, factors and minors are the same. What is remembered counts
as many steps as it took, so that a proof does not depend on what was remembered.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Hashable
from dataclasses import dataclass, field
from typing import Any, TypeVar

from robust_ik.certificates.effort import Effort

MOST = 30_000
"""Most results that are kept. Chosen: proofs of quick effort have up to 14,000, of about 1 kB; more fill memory."""

Result = TypeVar("Result")


@dataclass(frozen=True, eq=False)
class Memory:
    """The results of one case split.

    Attributes:
        known: Results and the steps that they took, by what they depend on.
    """

    known: dict[Hashable, tuple[Any, float]] = field(default_factory=dict, repr=False)

    def recall(self, key: Hashable, effort: Effort, made: Callable[[], Result]) -> Result:
        """The result of `made`, worked out once for each key; its steps are spent each time.

        Raises:
            TooLargeError: It is too large, or no steps are left; that is not remembered.
        """
        found = self.known.get(key)
        if found is not None:
            effort.spend(found[1])
            result: Result = found[0]
            return result
        before = effort.steps
        result = made()
        if len(self.known) < MOST:
            self.known[key] = result, before - effort.steps if math.isfinite(before) else 0.0
        return result
