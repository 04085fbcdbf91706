"""The two kinds of figures: bars of medians with quartiles, and cost against size."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import matplotlib as mpl
from matplotlib.figure import Figure

mpl.rcParams["svg.hashsalt"] = "robust_ik"  # the same numbers give the same file
SAVE = {"metadata": {"Date": None}, "bbox_inches": "tight"}

Spread = Mapping[str, float]
"""Median and quartiles."""


def bars(path: Path, groups: Mapping[str, Mapping[str, Spread]], label: str) -> None:
    """Horizontal bars on a logarithmic axis, a panel a group, the quartiles as whiskers.

    Args:
        path: The file.
        groups: Title → name → spread.
        label: Of the axis.
    """
    figure = Figure(figsize=(7, 0.6 + sum(0.6 + 0.24 * len(group) for group in groups.values())))
    heights = [max(len(group), 1) for group in groups.values()]
    panels = figure.subplots(len(groups), 1, squeeze=False, height_ratios=heights, sharex=True)[:, 0]
    for panel, (title, group) in zip(panels, groups.items()):
        for place, (name, spread) in enumerate(group.items()):
            own = name.startswith("robust_ik")
            panel.barh(place, spread["median"], color="tab:blue" if own else "0.7")
            panel.plot([spread["q1"], spread["q3"]], [place, place], color="black", linewidth=1.5)
        panel.set(xscale="log", title=title)
        panel.set_yticks(range(len(group)), list(group), fontsize=8)
        panel.invert_yaxis()
    panels[-1].set_xlabel(label)
    figure.tight_layout()
    figure.savefig(path, **SAVE)


def lines(path: Path, panels: Mapping[str, Mapping[str, Sequence[tuple[float, float]]]], label: str) -> None:
    """Cost against size, both axes logarithmic, a panel for each kind of size.

    Args:
        path: The file.
        panels: What is varied → name → (size, cost) pairs.
        label: Of the cost.
    """
    figure = Figure(figsize=(4.5 * len(panels), 3.5))
    for panel, (title, group) in zip(figure.subplots(1, len(panels), squeeze=False)[0], panels.items()):
        for name, points in group.items():
            panel.loglog(*zip(*points), marker="o", markersize=3, label=name)
        panel.set(xlabel=title, ylabel=label)
        panel.grid(which="both", alpha=0.3)
        if group:
            panel.legend(fontsize=7)
    figure.tight_layout()
    figure.savefig(path, **SAVE)
