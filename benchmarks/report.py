"""What a measurement leaves behind: a table, a JSON file with machine, versions and command, and a figure."""

from __future__ import annotations

import argparse
import importlib.metadata
import json
import os
import platform
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from benchmarks.tables import DOCS, markdown, parser, publish

PAGE = "benchmarks.md"
OUT = Path(__file__).parents[1] / "out" / "benchmarks"


def options(description: str | None) -> argparse.ArgumentParser:
    """The command line of a measurement with a report."""
    made = parser(description, PAGE)
    made.add_argument("--rounds", type=int, default=7, help="interleaved: all contenders, then all again")
    made.add_argument("--no-peers", action="store_true", help="only what runs in this process")
    return made


def machine() -> dict[str, Any]:
    """Where it was measured."""
    return {
        "cpu": cpu_model(),
        "cores": os.cpu_count(),
        "usable cores": len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count(),
        "load": os.getloadavg() if hasattr(os, "getloadavg") else None,
        "system": f"{platform.system()} {platform.machine()}",
        "python": platform.python_version(),
    }


def cpu_model() -> str:
    """The processor's name; what Python knows where there is no /proc."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        lines = []
    names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor() or "unknown"


def versions() -> dict[str, str]:
    """Every package of this environment."""
    found = {each.metadata["Name"]: each.version for each in importlib.metadata.distributions()}
    return dict(sorted(found.items(), key=lambda pair: pair[0].lower()))


def command() -> str:
    """How this program was started, without its directories."""
    script = Path(sys.argv[0])
    module = script.parent.name if script.stem == "__main__" else script.stem
    return " ".join(["python -m", f"benchmarks.{module}", *sys.argv[1:]])


@dataclass
class Report:
    """One measurement.

    Attributes:
        name: Of the files, and of the marks in the page.
        columns: Of the table, the first one text.
        rows: Of the table.
        results: Everything that was measured, for JSON.
        settings: Counts, seeds and the like.
        text_last: Whether the last column is text.
        figure: Draws it into a file.
        page: In docs, where the table goes.
    """

    name: str
    columns: Sequence[str]
    rows: Sequence[Sequence[str]] = ()
    results: dict[str, Any] = field(default_factory=dict)
    settings: dict[str, Any] = field(default_factory=dict)
    text_last: bool = False
    figure: Callable[[Path], None] | None = None
    page: str = PAGE

    def record(self) -> dict[str, Any]:
        """What the JSON file holds."""
        return {
            "name": self.name,
            "command": command(),
            "settings": self.settings,
            "machine": machine(),
            "versions": versions(),
            "results": self.results,
            "table": {"columns": list(self.columns), "rows": [list(row) for row in self.rows]},
        }

    def save(self, folder: Path) -> Path:
        """Writes JSON and figure into a folder."""
        folder.mkdir(parents=True, exist_ok=True)
        path = folder / f"{self.name}.json"
        path.write_text(json.dumps(self.record(), indent=1, allow_nan=False) + "\n", encoding="utf-8")
        if self.figure:
            self.figure(folder / f"{self.name}.svg")
        return path

    def publish(self, *, write: bool) -> None:
        """Prints the table and saves the rest; into docs too if so wanted."""
        publish(markdown(self.columns, self.rows, text_last=self.text_last), self.page, self.name, write=write)
        self.save(OUT)
        if write:
            self.save(DOCS / "benchmarks")
