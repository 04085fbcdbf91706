"""The trade-off of the robustness benchmark: calm against accuracy, a dot for each method, by its number in a key."""

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
IN_A_COLUMN = 28
"""Names of methods below each other in the key; beside the dots stand their numbers in it."""


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
    from matplotlib.ticker import LogLocator, NullFormatter, StrMethodFormatter

    shown = [(number, label) for number, label in PANELS if all(row.means[number] == row.means[number] for row in rows)]
    columns = -(-len(rows) // IN_A_COLUMN)
    figure = Figure(figsize=(4.4 * len(shown) + 2.1 * columns, 5.4), layout="constrained")
    *panels, key = figure.subplots(1, len(shown) + 1, width_ratios=[4.4] * len(shown) + [2.1 * columns])
    for panel, (number, label) in zip(panels, shown):
        for place, row in enumerate(rows):
            x, y = (max(row.means[name], LEAST) for name in (number, "kept"))
            own = row.on_front
            panel.plot(
                x, y, "o", color="tab:red" if own else "0.65", markersize=6 if own else 4, zorder=3 if own else 2
            )
            panel.annotate(
                str(place + 1), (x, y), xytext=(3, 2), textcoords="offset points", fontsize=6,
                color="black" if own else "0.45",
            )  # fmt: skip
        panel.set(xscale="log", yscale="log", xlabel=label)
        for axis in (panel.xaxis, panel.yaxis):
            axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
            axis.set_major_formatter(StrMethodFormatter("{x:g}"))
            axis.set_minor_formatter(NullFormatter())
        panel.grid(which="both", alpha=0.25)
        panel.tick_params(which="both", labelsize=6.5)
    key.axis("off")
    for place, row in enumerate(rows):
        across, down = divmod(place, IN_A_COLUMN)
        key.text(
            across / columns, 1 - (down + 0.5) / IN_A_COLUMN, in_figure(f"{place + 1} {row.name}"), fontsize=6.5,
            color="tab:red" if row.on_front else "0.45", transform=key.transAxes, va="center",
        )  # fmt: skip
    figure.supylabel("error in kept directions [rad, scaled], root mean square", fontsize=9)
    figure.suptitle("red: on the Pareto front of all four numbers; numbered by price", fontsize=9)
    return figure
