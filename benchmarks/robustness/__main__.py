"""Runs the neutral benchmark of singularity-robust control: every inverse and other packages, on twelve arms.

`python -m benchmarks.robustness` tunes each method on six arms and tells of six others. It prints a table, a figure
goes into out/benchmarks; with `--write` both go into docs/robustness.md. What has been measured is kept in
out/robustness, and taken from there where scenarios, methods and packages are still the same. The page's own runs are
kept beside it: `--only NAME --add` measures one contender, and tells of it among all others.
"""

from __future__ import annotations

from benchmarks.robustness import saved, telling
from benchmarks.robustness.agreement import agreements
from benchmarks.robustness.contenders import PEERS, TRIES, ours
from benchmarks.robustness.halves import measure
from benchmarks.tables import parser

PAGE = "robustness.md"


def main() -> None:
    options = parser(__doc__, PAGE)
    options.add_argument("--only", default="", help="contenders whose names contain this")
    options.add_argument(
        "--add", action="store_true", help="beside the rows that docs/benchmarks has of contenders not measured now"
    )
    options.add_argument("--no-peers", action="store_true", help="only this package")
    options.add_argument("--jobs", type=int, default=1, help="processes that share the work")
    options.add_argument(
        "--tries", type=int, default=TRIES, help="settings of each method that are tried; 0: none is tuned"
    )
    arguments = options.parse_args()
    everyone = [*ours(), *(() if arguments.no_peers else PEERS)]
    contenders = [each for each in everyone if arguments.only in each.name]
    before = saved.load(saved.FOLDER) if arguments.add else None
    results, failures, chosen = measure(contenders, arguments.jobs, arguments.tries)
    found = saved.rounded(results), failures, chosen
    if before is not None:
        found = saved.added(before, found, contenders, [*ours(), *PEERS])
    agreed = [] if arguments.no_peers or arguments.add else agreements()
    telling.tell(*found, agreed, page=PAGE, write=arguments.write)


if __name__ == "__main__":
    main()
