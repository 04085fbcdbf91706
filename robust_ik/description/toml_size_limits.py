"""Reads TOML text, and refuses text that would take time in the square of its length."""

from __future__ import annotations

import re
import tomllib
from typing import Any

MOST_PARTS = 100
"""Most parts of a dotted key; usual are three."""
_PART = r"(?:[A-Za-z0-9_-]++|\"(?:[^\"\\\n]|\\.)*+\"|'[^'\n]*+')"
_LONG_KEY = re.compile(rf"(?<![A-Za-z0-9_-])(?:{_PART}[ \t]*+\.[ \t]*+){{{MOST_PARTS}}}")


def read_toml(text: str) -> dict[str, Any]:
    """The table in TOML text.

    Raises:
        ValueError: It is no TOML, or nested or dotted too deeply.
    """
    if _LONG_KEY.search(text):
        raise ValueError(f"a key has over {MOST_PARTS} parts")
    try:
        return tomllib.loads(text)
    except RecursionError:
        raise ValueError("nested too deeply") from None
