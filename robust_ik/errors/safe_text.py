"""Makes text from outside (files, names, messages) safe for the place where it is shown.

A robot's file may call a joint anything. Such a name could move the cursor of a terminal, reverse the direction of
writing, be markup, or end a script. All text that is printed or written goes through one of these functions.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.text import Text

LATEX = {
    "\\": r"\ensuremath{\backslash}", "{": r"\{", "}": r"\}", "$": r"\$", "&": r"\&", "#": r"\#", "_": r"\_",
    "%": r"\%", "~": r"\ensuremath{\sim}", "^": r"\ensuremath{\wedge}",
}  # fmt: skip
"""LaTeX's special characters, each with a replacement that is valid in text and in formulas."""


def visible(text: object) -> str:
    """The text with every invisible character written as an escape, as in Python's literals.

    Escaped are control characters, ends of lines, characters without width or that change the direction of writing, and
    lone surrogates.
    """
    string = str(text)
    return string if string.isprintable() else "".join(map(_seen, string))


def _seen(letter: str) -> str:
    return letter if letter.isprintable() else letter.encode("unicode_escape").decode("ascii")


def visible_lines(text: object) -> str:
    """`visible`, line by line."""
    return "\n".join(map(visible, str(text).split("\n")))


def plain(text: object) -> Text:
    """The text for rich, exactly as it is: no markup, no emoji."""
    from rich.text import Text  # takes 10 ms: imported only where something is shown

    return Text(visible_lines(text))


def in_markup(text: object) -> str:
    """The text, escaped for use inside rich's markup."""
    from rich.markup import escape

    return escape(visible(text))


def in_html(text: object) -> str:
    """The text, escaped for HTML or SVG, in an element or a quoted attribute."""
    import html

    return html.escape(visible_lines(text))


def in_markdown(text: object) -> str:
    """The text, escaped for Markdown, also in a table's cell: it makes no HTML, links, code or emphasis."""
    escaped = re.sub(r"([\\`*\[\]|~$])", r"\\\1", visible(text))
    escaped = re.sub(r"(?<![A-Za-z0-9])_|_(?![A-Za-z0-9])", r"\\_", escaped)
    return escaped.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")


def in_latex(text: object, others: Mapping[str, str] | None = None) -> str:
    """The text, escaped for LaTeX, in text or in a formula.

    Args:
        text: Any object.
        others: Replacements of further characters.
    """
    written = {**LATEX, **(others or {})}
    return "".join(written.get(letter, letter) for letter in visible(text))


def in_figure(text: object) -> str:
    """The text, escaped for a figure of Matplotlib, which reads formulas between dollar signs."""
    return visible(text).replace("$", r"\$")
