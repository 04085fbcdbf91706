"""Measures every claim: `python -m benchmarks.claims`; `--write` puts the tables into notebooks/README.md."""

from __future__ import annotations

import importlib
import pkgutil
from pathlib import Path

from rich.console import Console
from rich.progress import track

import benchmarks.claims as papers
from benchmarks.tables import insert, markdown, parser

PAGE = Path(__file__).parents[2] / "notebooks" / "README.md"
COLUMNS = ("claim", "paper", "here", "verdict", "why")


def main() -> None:
    made = parser(__doc__, "../notebooks/README.md")
    made.add_argument("--papers", nargs="*", default=(), help="only these modules")
    arguments = made.parse_args()
    names = sorted(each.name for each in pkgutil.iter_modules(papers.__path__) if each.name.startswith("paper_"))
    chosen = [name for name in names if not arguments.papers or name in arguments.papers]
    for name in track(chosen, "measuring", console=Console(stderr=True)):
        claims = importlib.import_module(f"benchmarks.claims.{name}").claims()
        rows = [(each.what, each.paper, each.ours, each.verdict, each.why) for each in claims]
        table = markdown(COLUMNS, rows, text=True)
        print(table)
        if arguments.write:
            insert(table, PAGE, name)


if __name__ == "__main__":
    main()
