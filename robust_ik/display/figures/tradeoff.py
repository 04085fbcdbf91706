"""The trade-off of the robustness benchmark: calm against accuracy, a dot for each method."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from robust_ik.checks.public_arguments import checked
from robust_ik.display.figures.figure_files import save_figure
from robust_ik.errors import InputError
from robust_ik.errors.safe_text import in_figure
from robust_ik.runtime.output_files import check_figure
from robust_ik.simulation.robustness import MethodSummary

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PANELS = (
    ("speed", "peak of the commanded speed over its limit"),
    ("leave", "time to leave a singular configuration [s]"),
    ("chatter", "chatter [1/s]"),
)
LEAST = 1e-3
"""What a logarithmic axis shows in place of 0."""
NAMED = 12
"""Methods with names beside their dots: those of the lowest prices, and all that are on the front."""


@checked
def plot_tradeoff(summaries: Sequence[MethodSummary], path: str | Path) -> Path:
    """Draws the error in kept directions against peak speed, time to leave and chatter; less is better everywhere.

    Args:
        summaries: Of `BenchmarkResults.summaries`, the best placed first.
        path: Image to write: .png, .svg or .pdf.

    Raises:
        InputError: There is no row, or the path cannot be written.
    """
    if not summaries:
        raise InputError("there is nothing to draw: give at least one row")
    check_figure(path)
    return save_figure(_drawn(summaries), path, dpi=130)


def _drawn(rows: Sequence[MethodSummary]) -> Figure:
    from matplotlib.figure import Figure  # not pyplot, which opens windows and keeps state

    shown = [(number, label) for number, label in PANELS if all(row.means[number] == row.means[number] for row in rows)]
    figure = Figure(figsize=(5.2 * len(shown), 5.4), layout="constrained")
    for panel, (number, label) in zip(figure.subplots(1, len(shown), squeeze=False)[0], shown):
        for place, row in enumerate(rows):
            x, y = (max(row.means[name], LEAST) for name in (number, "kept"))
            own = row.on_front
            panel.plot(
                x, y, "o", color="tab:red" if own else "0.65", markersize=6 if own else 4, zorder=3 if own else 2
            )
            if own or place < NAMED:
                panel.annotate(
                    in_figure(row.name), (x, y), xytext=(4, 3), textcoords="offset points", fontsize=6.5,
                    color="black" if own else "0.45",
                )  # fmt: skip
        panel.set(xscale="log", yscale="log", xlabel=label)
        panel.grid(which="both", alpha=0.25)
        panel.tick_params(which="both", labelsize=6.5)
    figure.supylabel("error in kept directions [rad, scaled], root mean square", fontsize=9)
    figure.suptitle("red: on the Pareto front of all four numbers", fontsize=9)
    return figure
