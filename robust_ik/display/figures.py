"""Where figures may be written to."""

from __future__ import annotations

from pathlib import Path

from robust_ik.errors import InputError
from robust_ik.files import check_writable

FORMATS = (".png", ".svg", ".pdf")


def checked_figure(path: str | Path) -> Path:
    """The path of a figure, its folder made.

    Raises:
        InputError: It ends in no format of images, or cannot be written.
    """
    path = Path(path).expanduser()
    if path.suffix.lower() not in FORMATS:
        raise InputError(f"the figure is written as one of {', '.join(FORMATS)}, got {str(path)!r}")
    check_writable(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    return path
