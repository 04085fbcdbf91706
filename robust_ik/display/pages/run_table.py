"""Runs in numbers: a table with a column for each run, and charts of all runs."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence

import numpy as np

from robust_ik.checks import Array
from robust_ik.display.pages.svg_chart import ChartCurve, chart
from robust_ik.errors.safe_text import in_html
from robust_ik.kinematics.twist_rows import ROWS
from robust_ik.robot.robot import Robot
from robust_ik.simulation.trajectory import Trajectory


def results_table(names: Sequence[str], runs: Sequence[Trajectory], colors: Sequence[str]) -> str:
    """HTML of the table; its columns have data-run with the index of the run."""
    heads = "".join(
        f'<th scope="col" data-run="{index}" style="border-top: 3px solid {in_html(color)}">{breakable(name)}</th>'
        for index, (name, color) in enumerate(zip(names, colors))
    )
    rows = "".join(
        f'<tr><th scope="row">{in_html(label)}</th>'
        + "".join(f'<td data-run="{index}">{in_html(value)}</td>' for index, value in enumerate(values))
        + "</tr>"
        for label, values in _rows(runs)
    )
    return f"<table><thead><tr><td></td>{heads}</tr></thead><tbody>{rows}</tbody></table>"


def _rows(runs: Sequence[Trajectory]) -> list[tuple[str, list[str]]]:
    linear, angular = _kinds(runs[0].robot)
    rows = [(f"Largest speed [{_speed_unit(runs[0].robot)}]", [number(run.largest_speed) for run in runs])]
    if linear:
        rows.append(("Largest error [mm]", [number(1e3 * run.position_error.max()) for run in runs]))
        final = [1e3 * float(np.linalg.norm(run.final_error[:3])) for run in runs]
        rows.append(("Final error [mm]", [number(value) for value in final]))
    if angular:
        rows.append(("Largest error [°]", [number(np.degrees(run.rotation_error.max())) for run in runs]))
        final = [math.degrees(float(np.linalg.norm(run.final_error[3:]))) for run in runs]
        rows.append(("Final error [°]", [number(value) for value in final]))
    rows.append(("Smallest σ", [number(run.smallest_sigma) for run in runs]))
    rows.append(("Time per step [µs]", [number(1e6 * run.seconds_per_step) for run in runs]))
    return rows


def results_charts(runs: Sequence[Trajectory], colors: Sequence[str]) -> str:
    """SVG of the largest joint speed and of the tracking error over time."""
    duration = max(float(run.time[-1] - run.time[0]) for run in runs) or 1.0
    linear, _ = _kinds(runs[0].robot)

    def curves(values: Sequence[Array]) -> list[ChartCurve]:
        return [ChartCurve(run.time - run.time[0], value, color) for run, value, color in zip(runs, values, colors)]

    speeds = chart(
        f"Largest joint speed [{_speed_unit(runs[0].robot)}]",
        curves([np.abs(run.qdot).max(axis=1) for run in runs]),
        duration,
        logarithmic=True,
    )
    errors = (
        chart("Position error [mm]", curves([1e3 * run.position_error for run in runs]), duration)
        if linear
        else chart("Rotation error [°]", curves([np.degrees(run.rotation_error) for run in runs]), duration)
    )
    return speeds + errors


def number(value: float) -> str:
    """A number with three digits; tiny values are shown as 0."""
    value = float(value)
    if not math.isfinite(value):
        return "not finite"
    if value == 0 or abs(value) >= 1e6 or abs(value) < 1e-3:
        return "0" if abs(value) < 1e-9 else f"{value:.1e}"
    return f"{value:,.0f}" if abs(value) >= 1000 else f"{value:.3g}"


def breakable(name: str) -> str:
    """HTML of a name that may be wrapped between the words of CamelCase."""
    return re.sub(r"(?<=[a-z])(?=[A-Z])", "<wbr>", in_html(name))


def swatch(color: str) -> str:
    """HTML of a spot in a CSS colour."""
    return f'<i class="swatch" style="background:{in_html(color)}"></i>'


def _kinds(robot: Robot) -> tuple[bool, bool]:
    """Whether the task has rows of translation, and of rotation."""
    return any(row in ROWS[:3] for row in robot.rows), any(row in ROWS[3:] for row in robot.rows)


def _speed_unit(robot: Robot) -> str:
    slides = [robot.description.joint[name].kind == "prismatic" for name in robot.joint_names]
    if any(slides):
        return "m/s" if all(slides) else "rad/s or m/s"
    return "rad/s"
