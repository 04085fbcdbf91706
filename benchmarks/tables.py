"""Measured tables: printed, and put into a page between two marks."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

DOCS = Path(__file__).parents[1] / "docs"


def markdown(
    columns: Sequence[str], rows: Sequence[Sequence[str]], *, text_last: bool = False, text: bool = False
) -> str:
    """A Markdown table; the first column is text, and the last one or all if so said, the others are numbers.

    Args:
        columns: Titles.
        rows: Cells.
        text_last: Whether the last column is text.
        text: Whether all columns are.
    """
    numbers = ["---" if text else "---:"] * (len(columns) - 1 - text_last)
    lines = [columns, ["---", *numbers, *(["---"] if text_last else [])], *rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def parser(description: str | None, page: str) -> argparse.ArgumentParser:
    """Of a measurement that can put its table into a page of docs."""
    made = argparse.ArgumentParser(description=description, formatter_class=argparse.RawDescriptionHelpFormatter)
    made.add_argument("--write", action="store_true", help=f"put the table into docs/{page}")
    return made


def publish(table: str, page: str, mark: str, *, write: bool) -> None:
    """Prints a table, and puts it between `<!-- mark: begin -->` and `<!-- mark: end -->` of a page.

    Args:
        table: Markdown.
        page: File in docs.
        mark: What the table is called there.
        write: Whether to change the page.
    """
    print(table)
    if write:
        insert(table, DOCS / page, mark)


def insert(table: str, path: Path, mark: str) -> None:
    """Puts a table between `<!-- mark: begin -->` and `<!-- mark: end -->` of a page."""
    begin, end = f"<!-- {mark}: begin -->", f"<!-- {mark}: end -->"
    text = path.read_text(encoding="utf-8")
    before, after = text.split(begin)[0], text.split(end)[1]
    path.write_text(f"{before}{begin}\n{table}\n{end}{after}", encoding="utf-8")
