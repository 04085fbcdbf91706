"""Small charts over time as inline SVG, without scripts, fonts or images from elsewhere."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from robust_ik.checks import Array
from robust_ik.errors.safe_text import in_html

WIDTH, HEIGHT = 400.0, 132.0
"""Size of the drawing, in its own units: pages scale it. Chosen: flat, so that several fit one below the other."""
LEFT, RIGHT, TOP, BOTTOM = 46.0, 8.0, 20.0, 20.0
"""Margins in these units. Chosen: room for values on the left, the title at the top and times at the bottom."""
BINS = 240
"""Intervals of time with one point each. Chosen: in the 346 units between the margins finer ones cannot be seen."""
DECADES = 6
"""Most decades of a logarithmic axis. Chosen: more would flatten the curves; smaller values lie on its lower end."""


@dataclass(frozen=True, eq=False)
class ChartCurve:
    """One line of a chart.

    Attributes:
        time: Seconds, (N,).
        values: The values, (N,), not negative.
        color: A CSS colour.
    """

    time: Array
    values: Array
    color: str

    def envelope(self) -> tuple[Array, Array]:
        """The largest value in each of at most BINS intervals of time, so that a peak of one step stays visible."""
        edges = np.unique(np.linspace(0, len(self.time), min(BINS, len(self.time)) + 1).round().astype(int))
        return self.time[edges[:-1]], np.maximum.reduceat(self.values, edges[:-1])


@dataclass(frozen=True)
class Scale:
    """The map from values to heights in the chart.

    Attributes:
        low: Value at the bottom.
        high: Value at the top.
        logarithmic: Whether decades are evenly spaced.
    """

    low: float
    high: float
    logarithmic: bool

    @classmethod
    def for_values(cls, values: Array, logarithmic: bool) -> Scale:
        """A scale that holds the values; a logarithmic one of whole decades.

        It has at most DECADES of them, or as many as are needed to show the median of the values.
        """
        high = float(values.max(initial=0.0))
        if not logarithmic or high <= 0:
            return cls(0.0, _round_up(high) if high > 0 else 1.0, False)
        top = math.ceil(math.log10(high) - 1e-9)
        decades = np.log10(values[values > 0])
        lowest = min(top - DECADES, math.floor(np.median(decades)) - 1)
        bottom = max(min(math.floor(decades.min() + 1e-9), top - 1), lowest)
        return cls(10.0**bottom, 10.0**top, True)

    def height(self, values: Array) -> Array:
        """Distance from the upper edge of the drawing."""
        if self.logarithmic:
            share = np.log10(np.maximum(values, self.low) / self.low) / math.log10(self.high / self.low)
        else:
            share = values / self.high
        return np.asarray(HEIGHT - BOTTOM - np.clip(share, 0, 1) * (HEIGHT - TOP - BOTTOM))

    @property
    def ticks(self) -> list[float]:
        """Values of the labels beside the chart."""
        if not self.logarithmic:
            return [0.0, self.high / 2, self.high]
        bottom, top = round(math.log10(self.low)), round(math.log10(self.high))
        step = max(1, math.ceil((top - bottom) / 4))
        return [10.0**power for power in range(top, bottom - 1, -step)][::-1]


def chart(title: str, curves: Sequence[ChartCurve], duration: float, *, logarithmic: bool = False) -> str:
    """A chart of curves from 0 to `duration` seconds, with a line of class "cursor" for a script to move.

    The attributes data-left and data-width of the SVG give the position of time 0 and the width of the whole duration,
    as fractions of its width.
    """
    scale = Scale.for_values(np.concatenate([curve.values for curve in curves]), logarithmic)
    span = WIDTH - LEFT - RIGHT
    lines = [_polyline(curve, scale, duration) for curve in curves]
    return (
        f'<svg class="chart" viewBox="0 0 {WIDTH:g} {HEIGHT:g}" role="img" aria-label="{in_html(title)}" '
        f'data-left="{LEFT / WIDTH:.5f}" data-width="{span / WIDTH:.5f}">'
        f'<text class="title" x="{LEFT:g}" y="12">{in_html(title)}</text>'
        f"{_value_axis(scale)}{_time_axis(duration)}{''.join(lines)}"
        f'<line class="cursor" x1="{LEFT:g}" x2="{LEFT:g}" y1="{TOP:g}" y2="{HEIGHT - BOTTOM:g}"/></svg>'
    )


def _polyline(curve: ChartCurve, scale: Scale, duration: float) -> str:
    time, values = curve.envelope()
    x = LEFT + (WIDTH - LEFT - RIGHT) * time / duration
    points = " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(x, scale.height(values)))
    return f'<polyline points="{points}" stroke="{in_html(curve.color)}"/>'


def _value_axis(scale: Scale) -> str:
    marks = []
    for value, y in zip(scale.ticks, scale.height(np.array(scale.ticks))):
        marks.append(f'<line class="grid" x1="{LEFT:g}" x2="{WIDTH - RIGHT:g}" y1="{y:.1f}" y2="{y:.1f}"/>')
        marks.append(f'<text class="tick" x="{LEFT - 6:g}" y="{y + 3.5:.1f}" text-anchor="end">{_number(value)}</text>')
    return "".join(marks)


def _time_axis(duration: float) -> str:
    step = _round_up(duration / 5)
    marks = []
    for time in np.arange(0.0, duration + 1e-9 * duration, step):
        x = LEFT + (WIDTH - LEFT - RIGHT) * time / duration
        unit = " s" if time == 0 else ""
        marks.append(f'<text class="tick" x="{x:.1f}" y="{HEIGHT - 6:g}" text-anchor="middle">{time:.4g}{unit}</text>')
    return "".join(marks)


def _round_up(value: float) -> float:
    """The next of 1, 2, 5 times a power of ten."""
    power = 10.0 ** math.floor(math.log10(value))
    return next(step * power for step in (1, 2, 5, 10) if step * power >= value * (1 - 1e-9))


def _number(value: float) -> str:
    if value == 0 or 1e-3 <= value < 1e5:
        return f"{value:g}"
    return f"{value:.0e}".replace("e-0", "e-").replace("e+0", "e")
