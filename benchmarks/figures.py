"""The kinds of figures: bars of medians with quartiles, cost against size, and series in time."""

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


def series(path: Path, panels: Mapping[str, tuple[Sequence[float], Sequence[float]]], x: str, y: str) -> None:
    """Something against time, a panel a series, each with a scale of its own; a number that stays near zero shows flat.

    Args:
        path: The file.
        panels: Title → times and values.
        x: Label of the time.
        y: Label of the values.
    """
    columns = 3
    rows = -(-len(panels) // columns)
    figure = Figure(figsize=(4 * columns, 1.9 * rows))
    places = figure.subplots(rows, columns, squeeze=False, sharex=True).ravel()
    for place, (title, (times, values)) in zip(places, panels.items()):
        place.step(
            times, values, where="post", linewidth=1, color="tab:blue" if title.startswith("robust_ik") else "0.4"
        )
        most = max(0.01, *(1.1 * abs(value) for value in values))
        place.set_ylim(-most, most)
        place.set_title(title, fontsize=7)
        place.tick_params(labelsize=7)
        place.grid(alpha=0.3)
    for place in places[len(panels) :]:
        place.set_visible(False)
    figure.supxlabel(x, fontsize=9)
    figure.supylabel(y, fontsize=9)
    figure.tight_layout()
    figure.savefig(path, **SAVE)
