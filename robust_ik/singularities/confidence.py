"""How sure an atlas can be of one corank: counts, a hold-out of fresh starts, and the words for it."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

import scipy.special


class Status(Enum):
    """What an atlas knows of one corank; the value says it."""

    CERTIFIED = "certified: a proof that the list is complete was checked"
    EXACT = "exact, unchecked: an exact case split that no checker has accepted"
    IMPLICIT = "implicit: only the equations themselves are certified"
    ESTIMATE = "estimate: from random starts"
    NONE_FOUND = "none found: no random start led to such a configuration"
    INTERRUPTED = "interrupted: the search was stopped; there may be more"
    EVERYWHERE = "everywhere: fewer joints than task rows, so that every configuration loses as much"


@dataclass(frozen=True)
class Evidence:
    """What the search for one corank went through.

    Attributes:
        corank: k.
        status: What is known.
        starts: Random starts that the list was made from.
        found: How many of them led to a configuration of corank k or more.
        exact: How many of those have corank k and no more.
        unexplained: How many points no row accounts for.
        rejected: Candidate rows that failed the verification.
        fresh: Starts of the hold-out, made after the list was frozen.
        unmatched: How many of them met a stratum that is not in the list.
        floor: Least ‖r‖/σ₁ where none was found: how near to that corank the arm comes.
    """

    corank: int
    status: Status
    starts: int
    found: int
    exact: int
    unexplained: int = 0
    rejected: int = 0
    fresh: int = 0
    unmatched: int = 0
    floor: float = 0.0

    @property
    def bound(self) -> float:
        """Upper end, at 95 % confidence, of the probability that a further start meets an unlisted stratum.

        Source: Clopper and Pearson 1934, one-sided.
        """
        return missing_mass(self.unmatched, self.fresh)

    @property
    def words(self) -> str:
        """What may be said of completeness, and no more."""
        if self.status is Status.INTERRUPTED or self.fresh == 0:
            return f"corank {self.corank}: {self.status.value}"
        what = f"a configuration of corank {self.corank}" if self.status is Status.NONE_FOUND else "an unlisted stratum"
        return (
            f"with 95 % confidence a further random start of this finder meets {what} with probability below "
            f"{100 * self.bound:.2g} % ({self.unmatched} of {self.fresh})"
        )


def missing_mass(unmatched: int, fresh: int, confidence: float = 0.95) -> float:
    """Clopper and Pearson's upper bound of a probability of which `unmatched` of `fresh` trials are the record."""
    if fresh == 0 or unmatched >= fresh:
        return 1.0
    return float(scipy.special.betaincinv(unmatched + 1, fresh - unmatched, confidence))
