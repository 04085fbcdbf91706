"""SingularityAtlas: the result of a search, with its tables, its file, and a way to continue the search."""

from __future__ import annotations

from concurrent.futures import Executor
from dataclasses import dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

from robust_ik.checks.public_arguments import checked
from robust_ik.runtime.progress import ProgressCallback
from robust_ik.singularities.atlas import atlas_tables
from robust_ik.singularities.atlas.atlas_json import load, save
from robust_ik.singularities.atlas.atlas_record import AtlasRecord
from robust_ik.singularities.atlas.search_run import extend

if TYPE_CHECKING:
    from rich.table import Table


@dataclass(frozen=True, eq=False)
class SingularityAtlas(AtlasRecord):
    """The strata of an arm by corank; iterate over it for the strata, `str` gives a table.

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

    def __str__(self) -> str:
        return self.markdown()

    def extended(
        self, starts: int, *, executor: Executor | None = None, progress: ProgressCallback | None = None
    ) -> SingularityAtlas:
        """The atlas after further starts for each corank; its rows are kept and new ones added.

        Args:
            starts: Number of further starts for each corank.
            executor: An executor for the pieces, as for `find_singularities`.
            progress: Called with (steps done, steps in all).
        """
        return atlas_of(extend(self, starts, executor, progress))

    @checked
    def save(self, path: str | Path) -> Path:
        """Writes the atlas as JSON."""
        return save(self, path)

    @staticmethod
    def load(path: str | Path) -> SingularityAtlas:
        """Reads an atlas from JSON.

        Raises:
            LoadError: The file is no atlas, or of another version.
        """
        return atlas_of(load(path))

    def table(self) -> Table:
        """The atlas as a table for a terminal, by rich."""
        return atlas_tables.rich_table(self)

    def markdown(self) -> str:
        """The atlas as a Markdown table with the explanation below."""
        return atlas_tables.markdown(self)

    def latex(self) -> str:
        """The atlas as a LaTeX table."""
        return atlas_tables.latex(self)

    def to_pandas(self) -> Any:
        """The atlas as a data frame, one row per stratum; pandas must be installed."""
        return atlas_tables.to_pandas(self)

    def records(self) -> list[dict[str, Any]]:
        """One dictionary of plain values per stratum."""
        return atlas_tables.records(self)


def atlas_of(record: AtlasRecord) -> SingularityAtlas:
    """The atlas for the record of a search or a file."""
    return SingularityAtlas(**{each.name: getattr(record, each.name) for each in fields(record)})
