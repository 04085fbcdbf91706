"""An atlas as a table: plain records, rich, Markdown, LaTeX, pandas."""

from __future__ import annotations

import importlib
import re
from typing import TYPE_CHECKING, Any

import numpy as np
from rich import box
from rich.table import Table
from rich.text import Text

from robust_ik.errors import RobustIKError
from robust_ik.errors.safe_text import in_latex, in_markdown, plain, visible
from robust_ik.singularities.families.stratum import Stratum

if TYPE_CHECKING:
    from robust_ik.singularities.atlas.atlas_record import AtlasRecord

HEADINGS = ("corank", "conditions", "dim", "pieces", "within limits", "margin", "what is lost, as a wrench")
NO_LIMITS = "no limits"
SUBSCRIPT = re.compile(r"(?<![A-Za-z0-9\\])([A-Za-z])([0-9]+|\([0-9+-]+\))(?![A-Za-z0-9])")
"""A name of one letter and its index, in a formula."""
TEX = {
    "π": r"\pi ", "∈": r"\in", "±": r"\pm ", "−": "-", "½": r"\tfrac12 ", "·": r"\cdot ", "σ": r"\sigma ",
    "^": "^",  # a power; two of them would begin a character by its number in TeX
}  # fmt: skip


def records(atlas: AtlasRecord) -> list[dict[str, Any]]:
    """One dictionary of plain values per stratum."""
    return [
        {
            "corank": row.corank,
            "conditions": row.words,
            "dimension": row.dimension,
            "components": row.components,
            "components_exact": row.counted,
            "within_limits": row.within_limits,
            "margin": row.margin,
            "residual": row.residual,
            "off": row.off,
            "floor": row.floor,
            "fitted": row.fitted,
            "samples": len(row.samples),
            "lost": None if row.lost is None else str(row.lost),
        }
        for row in atlas
    ]


def cells(row: Stratum) -> tuple[str, ...]:
    """One row as text, below HEADINGS."""
    pieces = str(row.components) if row.counted else f"≈ {row.components}"
    margin = NO_LIMITS if np.isinf(row.margin) else f"{row.margin:+.3f}".replace("-", "−")
    lost = "" if row.lost is None else row.lost.words
    return str(row.corank), row.words, str(row.dimension), pieces, "yes" if row.within_limits else "no", margin, lost


def rich_table(atlas: AtlasRecord) -> Table:
    """A table for a terminal, also a narrow one: the lost motion stands below the conditions."""
    table = Table(
        title=plain(f"Singularities of {visible(atlas.robot.name)}"),
        caption=plain(atlas.explanation),
        caption_justify="left",
        box=box.SIMPLE_HEAD,
        padding=(0, 1, 0, 0),
    )
    table.add_column("corank", justify="right")
    table.add_column("conditions, and what is lost as a wrench", ratio=1)
    for heading in ("dim", "pieces", "within limits"):
        table.add_column(heading, justify="right")
    for row in atlas:
        corank, words, dimension, pieces, within, margin, lost = cells(row)
        both = Text.assemble(visible(words), "\n", (visible(lost), "dim")) if lost else plain(words)
        limits = margin if margin == NO_LIMITS else f"{within}, {margin}"
        table.add_row(corank, both, dimension, pieces, limits, end_section=row is atlas.of_corank(row.corank)[-1])
    return table


def markdown(atlas: AtlasRecord) -> str:
    """A Markdown table with the explanation below."""
    lines = ["| " + " | ".join(HEADINGS) + " |", "|" + "---|" * len(HEADINGS)]
    lines += ["| " + " | ".join(map(in_markdown, cells(row))) + " |" for row in atlas]
    table = "\n".join(lines) + "\n\n" if len(atlas) else ""
    return table + "\n".join(map(in_markdown, atlas.explanation.split("\n"))) + "\n"


def latex(atlas: AtlasRecord) -> str:
    """A LaTeX table (booktabs)."""
    lines = [r"\begin{tabular}{rlrrrrl}", r"\toprule", " & ".join(HEADINGS) + r" \\", r"\midrule"]
    for row in atlas:
        corank, words, *others = cells(row)
        texts = [corank, _conditions(words), *(_tex(each) for each in others)]
        lines.append(" & ".join(texts) + r" \\")
    return "\n".join([*lines, r"\bottomrule", r"\end{tabular}", ""])


def _conditions(words: str) -> str:
    return ", ".join(_tex(part) for part in words.split(" and "))


def _tex(text: str) -> str:
    """Text with LaTeX's special characters replaced, and formulas in mathematics mode."""
    if text.startswith("≈ "):
        return rf"$\approx {text[2:]}$"
    escaped = in_latex(text.replace("^^", "^ ^"), TEX)
    formula = "=" in text or "∈" in text or "−" in text
    if not formula or "no short" in text:
        return escaped
    return f"${SUBSCRIPT.sub(_lowered, escaped)}$"


def _lowered(found: re.Match[str]) -> str:
    """A name with its index as a subscript: q3, c23, s(2-3)."""
    return f"{found[1]}_{{{found[2].strip('()')}}}"


def to_pandas(atlas: AtlasRecord) -> Any:
    """A data frame with the records.

    Raises:
        RobustIKError: Pandas is not installed.
    """
    try:
        pandas = importlib.import_module("pandas")
    except ImportError:
        raise RobustIKError("to_pandas needs pandas: pip install pandas") from None
    return pandas.DataFrame.from_records(records(atlas))
