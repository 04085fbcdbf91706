"""A figure of gradient searches, step by step."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from robust_ik.checks.public_arguments import checked
from robust_ik.errors import InputError
from robust_ik.singularities.find import FOUND, Descent

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@checked
def descents_figure(descents: Mapping[str, Descent]) -> Figure:
    """The weakest singular values of searches over their steps; below them the turn of the gradient from step to step.

    A red line marks the ε of 1e-6 if it was reached.

    Args:
        descents: Searches by name, drawn side by side.

    Raises:
        InputError: There is none.
    """
    from matplotlib.figure import Figure  # not pyplot, which opens windows and keeps state

    if not descents:
        raise InputError("there is nothing to draw: give at least one descent")
    figure = Figure(figsize=(4.2 * len(descents) + 0.6, 4.6), layout="constrained")
    grid = figure.subplots(2, len(descents), sharex="col", squeeze=False)
    for (sigma, turn), (label, each) in zip(grid.T, descents.items()):
        count = each.s.shape[1]
        for index, values in enumerate(each.weakest.T, start=count - each.corank + 1):
            sigma.plot(values, linewidth=1.2, label=f"σ{index}")
        sigma.set(yscale="log", title=label)
        if each.converged:
            sigma.axhline(FOUND, color="red", linewidth=0.8)
            sigma.set_ylim(bottom=0.3 * FOUND)
        sigma.legend(fontsize="small")
        turn.plot(np.arange(1, len(each.turns) + 1), np.degrees(each.turns), color="C3", linewidth=0.8)
        turn.set(ylim=(0, 185), yticks=(0, 45, 90, 135, 180), xlabel="step")
        for axes in (sigma, turn):
            axes.grid(alpha=0.3)
    grid[0, 0].set_ylabel("σ")
    grid[1, 0].set_ylabel("turn of the gradient [°]")
    return figure
