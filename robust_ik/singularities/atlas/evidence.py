"""How sure an atlas can be of one corank: counts, a hold-out of fresh starts, and the words for it."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum


class Completeness(Enum):
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
        cases: Cases of the proof that was checked, if one was.
        leaves: Leaves of the proof.
        proof: Why there is no certificate, if there is none.
    """

    corank: int
    status: Completeness
    starts: int
    found: int
    exact: int
    unexplained: int = 0
    rejected: int = 0
    fresh: int = 0
    unmatched: int = 0
    floor: float = 0.0
    cases: int = 0
    leaves: int = 0
    proof: str = ""

    @property
    def estimated(self) -> Completeness:
        """The status without any proof."""
        if self.fresh == 0:
            return Completeness.INTERRUPTED
        return Completeness.ESTIMATE if self.found else Completeness.NONE_FOUND

    @property
    def bound(self) -> float:
        """Upper end, at 95 % confidence, of the probability that a further start meets an unlisted stratum.

        Source: Clopper and Pearson 1934, one-sided.
        """
        return missing_mass(self.unmatched, self.fresh)

    @property
    def words(self) -> str:
        """What may be said of completeness, and no more."""
        if self.status is Completeness.CERTIFIED:
            met = "none" if self.unmatched == 0 else f"{self.unmatched}"
            return self._certified + (f"; {met} of {self.fresh} fresh starts met another" if self.fresh else "")
        parts = [self._estimate]
        if self.status is Completeness.IMPLICIT:
            parts.insert(0, f"implicit: {self.cases} cases were checked, but only say again that it is singular")
        if self.proof:
            parts.append(self.proof)
        return "; ".join(parts)

    @property
    def _certified(self) -> str:
        if self.leaves == 0:
            return f"certified: there are none ({_counted(self.cases, 'case')} checked)"
        counts = f"{_counted(self.cases, 'case')} checked, {_counted(self.leaves, 'leaf', 'leaves')}"
        return f"certified: there are no others ({counts})"

    @property
    def _estimate(self) -> str:
        if self.fresh == 0:
            return Completeness.INTERRUPTED.value
        what = "an unlisted stratum" if self.found else f"a configuration of corank {self.corank}"
        return (
            f"with 95 % confidence a further random start of this finder meets {what} with probability below "
            f"{100 * self.bound:.2g} % ({self.unmatched} of {self.fresh})"
        )


def _counted(number: int, one: str, many: str = "") -> str:
    return f"{number} {one if number == 1 else many or one + 's'}"


def missing_mass(unmatched: int, fresh: int, confidence: float = 0.95) -> float:
    """Clopper and Pearson's upper bound of a probability of which `unmatched` of `fresh` trials are the record."""
    if fresh == 0 or unmatched >= fresh:
        return 1.0
    import scipy.special  # takes a tenth of a second: only where it is needed

    return float(scipy.special.betaincinv(unmatched + 1, fresh - unmatched, confidence))
