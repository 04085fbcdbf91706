"""Figures of runs over time: errors, joint speeds, singular values."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from robust_ik.checks import Array
from robust_ik.checks.public_arguments import checked
from robust_ik.display.figures.figure_files import save_figure
from robust_ik.errors import InputError, suggest
from robust_ik.errors.safe_text import in_figure
from robust_ik.runtime.output_files import check_figure
from robust_ik.simulation.trajectory import Trajectory

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Quantity = Callable[[Trajectory], Array]

QUANTITIES: Mapping[str, tuple[str, bool, Quantity]] = {
    "position error": ("position error [m]", True, lambda run: run.position_error),
    "rotation error": ("rotation error [rad]", True, lambda run: run.rotation_error),
    "joint speed": ("largest joint speed [rad/s]", True, lambda run: np.abs(run.qdot).max(axis=1)),
    "speed norm": ("‖q̇‖ [rad/s]", True, lambda run: np.linalg.norm(run.qdot, axis=1)),
    "sigma": ("smallest σ", True, lambda run: run.sigma[:, -1]),
    "ratio": ("σ_k/σ₁", True, lambda run: run.sigma[:, -1] / np.maximum(run.sigma[:, 0], 1e-300)),
    "manipulability": ("Π σ", True, lambda run: np.prod(run.sigma, axis=1)),
    "joints": ("joints [rad]", False, lambda run: run.robot.joint_values(run.q)),
}
"""Quantities that can be drawn: label of the axis, whether it is logarithmic, and the function that computes it."""

SHOWN = ("position error", "joint speed", "sigma")
FLOOR = 1e-12
"""The value at which a logarithmic axis shows zero."""


@checked
def runs_figure(runs: Mapping[str, Trajectory], quantities: Sequence[str] = SHOWN) -> Figure:
    """A figure of quantities of runs over time, one below the other.

    Args:
        runs: Runs by name.
        quantities: Of "position error", "rotation error", "joint speed", "speed norm", "sigma", "ratio",
            "manipulability", "joints".

    Raises:
        InputError: There is no run, or no such quantity.
    """
    from matplotlib.figure import Figure  # not pyplot, which opens windows and keeps state

    if not runs or not quantities:
        raise InputError("there is nothing to draw: give at least one run and one quantity")
    for name in quantities:
        if name not in QUANTITIES:
            raise InputError(f"there is no quantity {name!r}; {suggest(name, QUANTITIES)}")
    figure = Figure(figsize=(8, 2.1 * len(quantities) + 0.6), layout="constrained")
    axes = figure.subplots(len(quantities), 1, sharex=True, squeeze=False)[:, 0]
    first: list[Any] = []
    for ax, name in zip(axes, quantities):
        title, logarithmic, quantity = QUANTITIES[name]
        for index, run in enumerate(runs.values()):
            values = quantity(run)
            shown = np.where(values > FLOOR, values, FLOOR) if logarithmic else values
            lines = ax.plot(run.time, shown, color=f"C{index}", linewidth=1.2)
            if ax is axes[0]:
                first.append(lines[0])
        ax.set(ylabel=title, yscale="log" if logarithmic else "linear")
        ax.grid(alpha=0.3)
    axes[-1].set_xlabel("time [s]")
    legend = figure.legend(first, map(str, range(len(runs))), loc="outside upper center", ncols=3, fontsize="small")
    for text, name in zip(legend.get_texts(), runs):  # as labels, names that begin with "_" would be hidden
        text.set_text(in_figure(name))
    return figure


@checked
def plot_runs(runs: Mapping[str, Trajectory], path: str | Path, quantities: Sequence[str] = SHOWN) -> Path:
    """Writes `runs_figure` as an image.

    Args:
        runs: Runs by name.
        path: Image to write: .png, .svg or .pdf.
        quantities: As for `runs_figure`.

    Raises:
        InputError: As for `runs_figure`, or the path cannot be written.
    """
    check_figure(path)
    return save_figure(runs_figure(runs, quantities), path, dpi=110)
