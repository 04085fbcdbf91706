"""Figures of workspace maps."""

from __future__ import annotations

from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from robust_ik.checks.public_arguments import checked
from robust_ik.display.figures.figure_files import save_figure
from robust_ik.errors.safe_text import in_figure
from robust_ik.robot.workspace_map import WorkspaceMap
from robust_ik.runtime.output_files import check_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

VIEWS = (("x", "z"), ("y", "z"), ("x", "y"))
CELLS = 50
"""Cells along the longest side, if their size is not given."""


@checked
def plot_workspace(
    workspace: WorkspaceMap, path: str | Path, quantity: str = "smallest sigma", *, size: float | None = None
) -> Path:
    """Writes `workspace_figure` as an image.

    Args:
        workspace: A map from `map_workspace`.
        path: Image to write: .png, .svg or .pdf.
        quantity: As for `workspace_figure`.
        size: As for `workspace_figure`.

    Returns:
        The path.

    Raises:
        InputError: There is no such quantity, the cells are too many, or the path cannot be written.
    """
    check_figure(path)
    return save_figure(workspace_figure(workspace, quantity, size=size), path, dpi=130)


@checked
def workspace_figure(workspace: WorkspaceMap, quantity: str = "smallest sigma", *, size: float | None = None) -> Figure:
    """A figure of the best and the mean of a quantity over the workspace, seen from three sides.

    Each cell has all configurations along the line of sight.

    Args:
        workspace: A map from `map_workspace`.
        quantity: "smallest sigma", "manipulability" or "inverse condition".
        size: Side of a cell, m; by default a fiftieth of the longest extent.

    Raises:
        InputError: There is no such quantity, or the cells are too many.
    """
    from matplotlib.figure import Figure  # not pyplot, which opens windows and keeps state

    if size is None:
        # An arm whose tip does not move has one cell, of any size.
        size = float(np.ptp(workspace.positions, axis=0).max()) / CELLS or 1.0
    seen = [workspace.cells(quantity, size=size, axes=axes) for axes in VIEWS]
    highest = float(workspace.values(quantity).max())
    figure = Figure(figsize=(11, 7), layout="constrained")
    panels = figure.subplots(2, len(VIEWS), squeeze=False)
    for column, cells in enumerate(seen):
        for row, (name, shown) in enumerate((("best", cells.best), ("mean", cells.mean))):
            ax = panels[row, column]
            colours = ax.pcolormesh(*cells.edges, np.ma.masked_invalid(shown.T), vmin=0.0, vmax=highest or 1.0)
            ax.set(xlabel=f"{cells.axes[0]} [m]", ylabel=f"{cells.axes[1]} [m]", title=name, aspect="equal")
    label = f"{quantity} of {' '.join(workspace.rows)}"
    figure.colorbar(colours, ax=list(chain.from_iterable(panels)), label=label, shrink=0.8)
    figure.suptitle(f"{in_figure(workspace.robot.name)}: {len(workspace)} random configurations within the limits")
    return figure
