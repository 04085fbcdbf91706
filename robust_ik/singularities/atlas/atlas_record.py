"""The record of a search: families of singular configurations, how complete they are, and queries about them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Self

from numpy.typing import ArrayLike

from robust_ik.certificates import Certificate
from robust_ik.checks.public_arguments import checked
from robust_ik.errors import RobustIKError
from robust_ik.singularities.atlas.evidence import Completeness, Evidence
from robust_ik.singularities.conditions.robot_facts import RobotFacts
from robust_ik.singularities.families.stratum import Stratum
from robust_ik.singularities.find.find_points import Method
from robust_ik.singularities.trace.nearest_singularity import Nearest, nearest

if TYPE_CHECKING:
    from robust_ik.singularities.trace.coupled_curves import Curve

ON = 1e-6
"""Distance up to which a configuration counts as one of a family, rad. Chosen: what polished points keep."""


class NoSingularitiesError(RobustIKError):
    """The atlas holds no strata, or is not complete."""


@dataclass(frozen=True)
class Settings:
    """Settings of a search: with the same settings and version of the package, the atlas is the same.

    Attributes:
        corank: The only corank that was looked for, or None for all.
        seed: Seed of all random numbers.
        starts: Random starts for each corank.
        tolerance: ‖r‖/σ₁ that counts as zero.
        method: "projection" or "gradient".
        certified: Whether proofs were tried.
    """

    corank: int | None
    seed: int
    starts: int
    tolerance: float
    method: Method
    certified: bool = True


@dataclass(frozen=True, eq=False)
class AtlasRecord:
    """The values of an atlas: strata by corank. Iterate over it for the strata; `str` gives a table.

    Attributes:
        robot: Facts of the robot.
        strata: Rows, coranks ascending, large dimensions first.
        evidence: Evidence for the completeness of each corank.
        settings: Settings of the search.
        interrupted: Whether it was stopped before it was done.
        certificate: The proofs that were tried, checked if complete; None if none was asked for.
        nearly: Rows of the arm without its small tilts and offsets, as far as a short search finds them, that are none
            of the arm itself: there it is nearly singular, or has singular configurations nearby that no short
            relation describes; see `off` and `floor` of each.
    """

    robot: RobotFacts
    strata: tuple[Stratum, ...]
    evidence: tuple[Evidence, ...]
    settings: Settings
    interrupted: bool = False
    certificate: Certificate | None = field(default=None, repr=False)
    nearly: tuple[Stratum, ...] = ()

    def __iter__(self) -> Iterator[Stratum]:
        return iter(self.strata)

    def __len__(self) -> int:
        return len(self.strata)

    @checked
    def of_corank(self, corank: int) -> tuple[Stratum, ...]:
        """The rows of one corank."""
        return tuple(stratum for stratum in self.strata if stratum.corank == corank)

    @property
    def highest(self) -> int:
        """The highest corank that was found; 0 if none was."""
        return max((stratum.corank for stratum in self.strata), default=0)

    @property
    def explanation(self) -> str:
        """What was analysed, what was found, how complete it is, and where the arm is nearly singular, in sentences."""
        return ".\n".join([*self.sureness, *self.nearness]) + "."

    @property
    def sureness(self) -> list[str]:
        """What was analysed, what was found, and how complete it is: sentences without their full stops."""
        facts, lines = self.robot, []
        if facts.reduced:
            lines.append(facts.reduced)
        if facts.changes:
            lines.append(_straightening(facts, self.strata))
        lines += [f"corank {each.corank}: {self._found(each)}; {each.words}" for each in self.evidence]
        if self.interrupted:
            lines.append("the search was interrupted: this is what it had found")
        return lines

    @property
    def nearness(self) -> list[str]:
        """Where the arm is nearly singular because of small tilts and offsets: sentences without their full stops."""
        if not self.nearly:
            return []
        told = [f"nearly singular, for small tilts and offsets ({'; '.join(self.robot.near_changes)})"]
        for row in self.nearly:
            met = f"σ up to {row.off:.1g} was met there, and it falls to {row.floor:.1g} nearby"
            told.append(f"nearly of corank {row.corank}: {row.words}: {met}")
        return told

    def _found(self, evidence: Evidence) -> str:
        rows = self.of_corank(evidence.corank)
        if evidence.status is Completeness.NEVER:
            return "none within the limits"
        if not rows and evidence.status is Completeness.INTERRUPTED:
            return "none found yet"
        if not rows and not evidence.found:
            return f"none found by {evidence.fresh} starts, which came no nearer than ‖r‖ = {evidence.floor:.2g} σ₁"
        families = "1 family" if len(rows) == 1 else f"{len(rows)} families"
        pieces = sum(row.components for row in rows)
        rest = f", {evidence.unexplained} points unexplained" if evidence.unexplained else ""
        return f"{families} in {pieces} {'piece' if pieces == 1 else 'pieces'}{rest}"

    def raise_for_status(self) -> Self:
        """The atlas itself if it holds strata and was not interrupted.

        Raises:
            NoSingularitiesError: It does not; the message explains.
        """
        if not self.strata or self.interrupted:
            raise NoSingularitiesError(f"{self.robot.name}: {self.explanation}")
        return self

    @checked
    def distance(self, q: ArrayLike) -> Nearest:
        """The singular configuration nearest to q, (n,) or (nq,), without regard to limits.

        Raises:
            NoSingularitiesError: The atlas is empty.
        """
        return self.distances(q)[0]

    @checked
    def distances(self, q: ArrayLike) -> list[Nearest]:
        """For each stratum its configuration nearest to q, the nearest stratum first."""
        if not self.strata:
            raise NoSingularitiesError(f"{self.robot.name}: {self.explanation}")
        return nearest(self.robot, self.strata, self.robot.values(q))

    @checked
    def said_of(self, q: ArrayLike) -> str:
        """The nearest family, how far away it is, what is lost there and where self-motions lead, as one clause.

        Args:
            q: Configuration, (n,) or (nq,).
        """
        if not self.strata:
            return "no family is listed"
        near = self.distance(q)
        where = "on" if near.distance <= ON else f"{near.distance:.2g} rad from"
        lost = "" if near.stratum.lost is None else f": {near.stratum.lost}"
        return f"{where} {near.stratum.words}, corank {near.stratum.corank}{lost}"

    @checked
    def curves(self, stratum: Stratum) -> tuple[Curve, ...]:
        """The curves of the coupled joints of a row: closed curves if they have one degree of freedom, else points.

        They are empty if no joints are coupled.
        """
        from robust_ik.singularities.trace.coupled_curves import trace  # imports atlases

        return trace(self, stratum)


def _straightening(facts: RobotFacts, strata: Sequence[Stratum]) -> str:
    """The changes of the geometry before the analysis, and their consequences, in words."""
    changes = "; ".join(facts.changes)
    if facts.snapped:
        return f"nominal geometry, straightened as asked: {changes}"
    nearly = [row for row in strata if row.floor > 0]
    rounded = "numbers" if any("lengths" in each for each in facts.changes) else "angles"
    words = f"the model's {rounded} are rounded; these are the strata of the straight geometry ({changes})"
    if not strata:
        return words
    if not nearly:
        return f"{words}; the model as given has them too, nearby"
    floors = f"{min(row.floor for row in nearly):.1g} to {max(row.floor for row in nearly):.1g}"
    return (
        f"{words}; the model as given has {len(strata) - len(nearly)} of the {len(strata)} families too, nearby; near "
        f"the others it is only nearly singular, σ falling no lower than {floors}"
    )
