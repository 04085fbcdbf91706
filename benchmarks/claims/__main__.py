"""Measures every claim: `python -m benchmarks.claims`.

`--write` keeps the numbers (benchmarks/claims/measured) and puts the tables into notebooks/README.md; `--check` says
what a fresh measurement gives differently, and fails if that is anything. Ranges agree where they overlap.
"""

from __future__ import annotations

import importlib
import pkgutil
import sys
from pathlib import Path

from rich.console import Console
from rich.progress import track

import benchmarks.claims as papers
from benchmarks.claims import measured
from benchmarks.claims.claim import Claim
from benchmarks.tables import insert, parser

PAGE = Path(__file__).parents[2] / "notebooks" / "README.md"


def main() -> None:
    made = parser(__doc__, "../notebooks/README.md")
    made.add_argument("--check", action="store_true", help="compare with what the page says")
    made.add_argument("--papers", nargs="*", default=(), help="only these modules")
    arguments = made.parse_args()
    names = sorted(each.name for each in pkgutil.iter_modules(papers.__path__) if each.name.startswith("paper_"))
    chosen = [name for name in names if not arguments.papers or name in arguments.papers]
    found = []
    for name in track(chosen, "measuring", console=Console(stderr=True)):
        claims = importlib.import_module(f"benchmarks.claims.{name}").claims()
        if arguments.check:
            found += measured.differences(claims, measured.read(name))
        else:
            report(name, claims, write=arguments.write)
    if arguments.check:
        print("\n".join(found) or "a fresh measurement says what the page says")
        sys.exit(1 if found else 0)


def report(name: str, claims: list[Claim], *, write: bool) -> None:
    """Prints a paper's table, and keeps it."""
    if write:
        claims = measured.renewed(claims, measured.read(name))
        measured.write(name, claims)
    table = measured.table(claims)
    print(table)
    if write:
        insert(table, PAGE, name)


if __name__ == "__main__":
    main()
