"""Evidence that the list of one corank is complete: counts, a hold-out of fresh starts, and the words for it."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum


class Completeness(Enum):
    """How complete the list of one corank is; the value is the explanation."""

    CERTIFIED = "certified: a proof that the list is complete was checked"
    EXACT = "exact, unchecked: an exact case split that no checker has accepted"
    IMPLICIT = "implicit: only the equations themselves are certified"
    ESTIMATE = "estimate: from random starts"
    NONE_FOUND = "none found: no random start led to such a configuration"
    INTERRUPTED = "interrupted: the search was stopped; there may be more"
    NEVER = "never: a floating base moves the tip in every direction, within the limits of its pitch"
    EVERYWHERE = "everywhere: fewer joints than task rows, so that every configuration loses as much"


@dataclass(frozen=True)
class Evidence:
    """Counts of the search for one corank, its hold-out and its proof.

    Attributes:
        corank: k.
        status: How complete the list is.
        starts: Random starts from which the list was made.
        found: How many of them led to a configuration of corank k or more.
        exact: How many of those have corank k and no more.
        unexplained: How many points lie on no row.
        rejected: Candidate rows that failed the verification.
        fresh: Starts of the hold-out, made after the list was frozen.
        unmatched: How many of them met a stratum that is not in the list.
        floor: If none was found, the least ‖r‖/σ₁: how close the arm comes to that corank.
        cases: Cases of the proof that was checked, if one was.
        leaves: Leaves of the proof.
        proof: Why there is no certificate, if there is none; why the arm is never singular, if it is not.
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
        """Upper bound, with 95 % confidence, of the probability that a further start meets an unlisted stratum.

        Source: Clopper and Pearson 1934, one-sided.
        """
        return missing_mass(self.unmatched, self.fresh)

    @property
    def words(self) -> str:
        """What can be said about completeness, in words."""
        if self.status is Completeness.NEVER:
            return self.proof
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
            f"{_percent(self.bound)} % ({self.unmatched} of {self.fresh})"
        )


def _counted(number: int, one: str, many: str = "") -> str:
    return f"{number} {one if number == 1 else many or one + 's'}"


def missing_mass(unmatched: int, fresh: int, confidence: float = 0.95) -> float:
    """Clopper and Pearson's upper bound of a probability after `unmatched` of `fresh` trials."""
    if fresh == 0 or unmatched >= fresh:
        return 1.0
    import scipy.special  # takes 0.1 s: imported only if needed

    return float(scipy.special.betaincinv(unmatched + 1, fresh - unmatched, confidence))


def _percent(share: float) -> str:
    """A share in per cent, with two digits."""
    return "100" if share > 0.995 else f"{100 * share:.2g}"
