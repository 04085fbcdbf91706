"""Curves of coupled joints as small inline SVG panels, without scripts, fonts or images from elsewhere."""

from __future__ import annotations

import numpy as np

from robust_ik.checks import Array
from robust_ik.errors.safe_text import in_html
from robust_ik.singularities.geometry import ScrewChain
from robust_ik.singularities.trace import Axis, Curve, pairs, strokes

SIDE, LEFT, BOTTOM, RIGHT, TOP = 200.0, 34.0, 30.0, 12.0, 8.0
"""Side of the square for the drawing, and the margins around it."""


def curve_panels(chain: ScrewChain, curves: tuple[Curve, ...], now: Array) -> str:
    """HTML of a panel for each pair of coupled joints, with a dot that a script may move; empty if there are none.

    The dot has attributes with the indices of its joints, and with the map from their values in degrees or m to its
    position.

    Args:
        chain: What moves the tip.
        curves: Curves from `trace`.
        now: Joint values of the dot, (n,).
    """
    panels = "".join(_panel(across, up, curves, now) for across, up in pairs(chain, curves))
    return f'<div class="panels">{panels}</div>' if panels else ""


def _panel(across: Axis, up: Axis, curves: tuple[Curve, ...], now: Array) -> str:
    drawn = "".join(_drawn(curve, across, up) for curve in curves)
    title = in_html(f"{up.label} against {across.label}")
    x, y = _place(np.array([[across.shown(now), up.shown(now)]]), across, up)[0]
    return (
        f'<svg class="panel" viewBox="0 0 {LEFT + SIDE + RIGHT:g} {TOP + SIDE + BOTTOM:g}" role="img" '
        f'aria-label="{title}">{_grid(across, up)}'
        f'<svg x="{LEFT:g}" y="{TOP:g}" width="{SIDE:g}" height="{SIDE:g}" viewBox="0 0 {SIDE:g} {SIDE:g}">{drawn}'
        f'<circle class="now" cx="{x:.1f}" cy="{y:.1f}" r="5" data-joints="{across.joint} {up.joint}" '
        f'data-x="{across.low:g} {across.high:g}" data-y="{up.low:g} {up.high:g}"/></svg></svg>'
    )


def _drawn(curve: Curve, across: Axis, up: Axis) -> str:
    if curve.ordered:
        lines = [_place(piece, across, up) for piece in strokes(curve, across, up)]
        path = " ".join(f"M{'L'.join(f'{x:.1f} {y:.1f}' for x, y in line)}" for line in lines)
        return f'<path class="line" d="{path}"/>'
    points = _place(np.stack([across.shown(curve.values), up.shown(curve.values)], axis=1), across, up)
    return f'<path class="points" d="{" ".join(f"M{x:.1f} {y:.1f}h0" for x, y in points)}"/>'


def _place(points: Array, across: Axis, up: Axis) -> Array:
    """Positions in the panel of joint values, (P, 2)."""
    x = SIDE * (points[:, 0] - across.low) / (across.high - across.low)
    y = SIDE * (up.high - points[:, 1]) / (up.high - up.low)
    return np.stack([x, y], axis=1)


def _grid(across: Axis, up: Axis) -> str:
    marks = [f'<rect class="frame" x="{LEFT:g}" y="{TOP:g}" width="{SIDE:g}" height="{SIDE:g}"/>']
    for value in across.ticks:
        x = LEFT + SIDE * (value - across.low) / (across.high - across.low)
        marks.append(f'<line class="grid" x1="{x:.1f}" x2="{x:.1f}" y1="{TOP:g}" y2="{TOP + SIDE:g}"/>')
        marks.append(f'<text x="{x:.1f}" y="{TOP + SIDE + 12:g}" text-anchor="middle">{_tick(value)}</text>')
    for value in up.ticks:
        y = TOP + SIDE * (up.high - value) / (up.high - up.low)
        marks.append(f'<line class="grid" x1="{LEFT:g}" x2="{LEFT + SIDE:g}" y1="{y:.1f}" y2="{y:.1f}"/>')
        marks.append(f'<text x="{LEFT - 4:g}" y="{y + 3.5:.1f}" text-anchor="end">{_tick(value)}</text>')
    middle = LEFT + SIDE / 2
    marks.append(
        f'<text class="name" x="{middle:g}" y="{TOP + SIDE + 26:g}" text-anchor="middle">{in_html(across.label)}'
        f'</text><text class="name" x="9" y="{TOP + SIDE / 4:g}" text-anchor="middle" '
        f'transform="rotate(-90 9 {TOP + SIDE / 4:g})">{in_html(up.label)}</text>'
    )
    return "".join(marks)


def _tick(value: float) -> str:
    return f"{value:g}".replace("-", "−")
