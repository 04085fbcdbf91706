"""Writes figures to files."""

from __future__ import annotations

import warnings
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING

from robust_ik.runtime.output_files import check_figure, write_file

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def save_figure(figure: Figure, path: str | Path, dpi: int) -> Path:
    """Writes a figure in the format of the path's ending, whole or not at all.

    Raises:
        InputError: The ending is no image format, or the file cannot be written.
    """
    path, content = check_figure(path), BytesIO()
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "Glyph .* missing from", UserWarning)  # in names: drawn as a box
        figure.savefig(content, dpi=dpi, format=path.suffix[1:].lower())
    return write_file(path, content.getvalue())
