"""Text from outside (files, names, messages), made safe for where it is shown.

A robot's file may call a joint anything: what would move the cursor of a terminal, turn the direction of writing round,
be markup, or end a script. Whatever is printed or written goes through one of these.
"""

from __future__ import annotations

import html
import re
from collections.abc import Mapping
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.text import Text

LATEX = {
    "\\": r"\ensuremath{\backslash}", "{": r"\{", "}": r"\}", "$": r"\$", "&": r"\&", "#": r"\#", "_": r"\_",
    "%": r"\%", "~": r"\ensuremath{\sim}", "^": r"\ensuremath{\wedge}",
}  # fmt: skip
"""What LaTeX would take for a command, as it is written in text and in formulas."""


def visible(text: object) -> str:
    """Text of which every letter is seen and takes its place: all others are written as in Python's literals.

    Those are control letters, ends of lines, letters without width or that turn the direction of writing round, and
    halves of letters.
    """
    string = str(text)
    return string if string.isprintable() else "".join(map(_seen, string))


def _seen(letter: str) -> str:
    return letter if letter.isprintable() else letter.encode("unicode_escape").decode("ascii")


def visible_lines(text: object) -> str:
    """`visible`, line by line."""
    return "\n".join(map(visible, str(text).split("\n")))


def plain(text: object) -> Text:
    """For rich, as it stands: no markup, no emoji."""
    from rich.text import Text  # a hundredth of a second: only where something is shown

    return Text(visible_lines(text))


def in_markup(text: object) -> str:
    """To stand inside rich's markup."""
    from rich.markup import escape

    return escape(visible(text))


def in_html(text: object) -> str:
    """To stand in HTML or SVG, in an element or a quoted attribute."""
    return html.escape(visible_lines(text))


def in_markdown(text: object) -> str:
    """To stand in Markdown, also in a table's cell: no HTML, links, code or emphasis come of it."""
    escaped = re.sub(r"([\\`*\[\]|~$])", r"\\\1", visible(text))
    escaped = re.sub(r"(?<![A-Za-z0-9])_|_(?![A-Za-z0-9])", r"\\_", escaped)
    return escaped.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")


def in_latex(text: object, others: Mapping[str, str] | None = None) -> str:
    """To stand in LaTeX, in text or in a formula.

    Args:
        text: Any.
        others: What further letters are written as.
    """
    written = {**LATEX, **(others or {})}
    return "".join(written.get(letter, letter) for letter in visible(text))


def in_figure(text: object) -> str:
    """To stand in a figure of Matplotlib, which would read formulas between dollars."""
    return visible(text).replace("$", r"\$")
