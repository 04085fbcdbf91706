"""A figure of the curves of coupled joints along a family of singular configurations."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from robust_ik.checks.public_arguments import checked
from robust_ik.display.figures.figure_files import save_figure
from robust_ik.errors import InputError
from robust_ik.errors.safe_text import in_figure
from robust_ik.runtime.output_files import check_figure
from robust_ik.singularities.atlas import SingularityAtlas
from robust_ik.singularities.families import Stratum
from robust_ik.singularities.trace import Axis, Curve, pairs, strokes, trace

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

INK = "#1c6fb8"
ACROSS = 3
"""Panels in a row: at 3.6 inches each they fit the width of a page in landscape, 11 inches."""


@checked
def plot_curves(atlas: SingularityAtlas, stratum: Stratum, path: str | Path) -> Path:
    """Writes `curves_figure` as an image.

    Args:
        atlas: The atlas that holds it.
        stratum: One of its rows, with coupled joints.
        path: Image to write: .png, .svg or .pdf.

    Returns:
        The path.

    Raises:
        InputError: No joints are coupled, or the path cannot be written.
    """
    check_figure(path)
    return save_figure(curves_figure(atlas, stratum), path, dpi=130)


@checked
def curves_figure(atlas: SingularityAtlas, stratum: Stratum) -> Figure:
    """A figure of the coupled joints of a stratum, with a panel for each pair of them.

    Args:
        atlas: The atlas that holds it.
        stratum: One of its rows, with coupled joints.

    Raises:
        InputError: No joints are coupled.
    """
    from matplotlib.figure import Figure  # not pyplot, which opens windows and keeps state

    curves = trace(atlas, stratum)
    panels = pairs(atlas.robot.chain, curves)
    if not panels:
        raise InputError(f"no joints are coupled where {stratum.words}: there is no curve to draw")
    down, over = -(-len(panels) // ACROSS), min(ACROSS, len(panels))
    figure = Figure(figsize=(3.6 * over, 3.6 * down + 0.4), layout="constrained")
    grid = figure.subplots(down, over, squeeze=False).ravel()
    for axes, (across, up) in zip(grid, panels):
        _draw(axes, curves, across, up)
    for axes in grid[len(panels) :]:
        axes.set_visible(False)
    figure.suptitle(f"{in_figure(atlas.robot.name)}, corank {stratum.corank}")
    return figure


def _draw(axes: Axes, curves: tuple[Curve, ...], across: Axis, up: Axis) -> None:
    for curve in curves:
        if not curve.ordered:
            axes.plot(across.shown(curve.values), up.shown(curve.values), ".", color=INK, markersize=1.5)
            continue
        for piece in strokes(curve, across, up):
            axes.plot(piece[:, 0], piece[:, 1], color=INK, linewidth=1.4)
    axes.set(xlim=(across.low, across.high), ylim=(up.low, up.high), xlabel=across.label, ylabel=up.label)
    axes.set(xticks=np.array(across.ticks), yticks=np.array(up.ticks))
    axes.set_box_aspect(1)
    axes.grid(alpha=0.3)
