"""Where figures may be written to."""

from __future__ import annotations

from pathlib import Path

from robust_ik.files import check_figure


def checked_figure(path: str | Path) -> Path:
    """The path of a figure, its folder made.

    Raises:
        InputError: It ends in no format of images, or cannot be written.
    """
    path = Path(path).expanduser()
    check_figure(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    return path
