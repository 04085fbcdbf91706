"""Pages of the robustness benchmark: an index with the table, and one with curves for each scenario that is shown."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from robust_ik.checks.public_arguments import checked
from robust_ik.display.pages.comparison_page import PALETTE
from robust_ik.display.pages.run_table import number, swatch
from robust_ik.display.pages.svg_chart import ChartCurve, chart
from robust_ik.display.scene.html_page import asset
from robust_ik.errors import InputError
from robust_ik.errors.safe_text import in_html
from robust_ik.runtime.output_files import write_file
from robust_ik.simulation.robustness import BenchmarkResults, MethodSummary, RunKey, RunScore

MOST = len(PALETTE)
"""Methods in the charts of a page, the best placed ones: more could not be told apart."""
HEADINGS = (
    ("kept", "error kept"), ("lost", "error lost"), ("leave", "to leave [s]"), ("left", "left"),
    ("speed", "peak / limit"), ("chatter", "chatter [1/s]"), ("violations", "over limits"), ("failed", "failed"),
)  # fmt: skip
TITLES = (
    "Error in kept directions [rad, scaled]",
    "Error in lost directions [rad, scaled]",
    "Commanded speed over limit",
)
POLICY = "default-src 'none'; style-src 'unsafe-inline'; img-src data:"


@checked
def write_robustness_html(folder: str | Path, results: BenchmarkResults) -> Path:
    """Writes `index.html` and a page for each scenario whose curves are kept into a folder.

    Args:
        folder: Made if only it is missing.
        results: Of at least one method and scenario.

    Returns:
        The path of the index.

    Raises:
        InputError: There is nothing to show, or nothing can be written there.
    """
    if not results.scores or not results.scenarios:
        raise InputError("there is nothing to show: run at least one method on one robot")
    rows = results.summaries()
    place = Path(folder).expanduser()
    shown = [key for key in results.scenarios if any(runs[key].curves for runs in results.scores.values())]
    names = {key: f"scenario-{index:03d}.html" for index, key in enumerate(shown, 1)}
    written = write_file(place / "index.html", _index(rows, names))
    for key, name in names.items():
        write_file(place / name, _scenario_page(results, rows, key))
    return written


def _index(rows: Sequence[MethodSummary], names: dict[RunKey, str]) -> str:
    heads = "".join(f"<th>{in_html(title)}</th>" for _, title in HEADINGS)
    body = "".join(_summary_row(place, row) for place, row in enumerate(rows, 1))
    links: dict[str, list[str]] = {}
    for key, name in names.items():
        links.setdefault(key.robot, []).append(f'<li><a href="{name}">{in_html(key.name)}</a></li>')
    lists = "".join(f"<h3>{in_html(robot)}</h3><ul>{''.join(found)}</ul>" for robot, found in links.items())
    return _document(
        "Robustness near singularities",
        f"<p>{in_html(EXPLANATION)}</p><div class='scroll'><table><thead><tr><th>method</th><th>price</th>"
        f"<th>on the front</th>{heads}</tr></thead><tbody>{body}</tbody></table></div><h2>Scenarios</h2>{lists}",
    )


EXPLANATION = (
    "Means over robots and classes of scenarios. Rows are ranked by price, the mean of the kept error over 0.02, "
    "the peak over the limit, the seconds to leave a singular configuration, and the chatter over 2 per second. A "
    "method is on the front if no other is no worse in all four and better in one; below it stands in how many of "
    "the resamples it is."
)


def _summary_row(place: int, row: MethodSummary) -> str:
    low, high = row.intervals["price"]
    front = "yes" if row.on_front else f"no: {row.beaten_by[0]}"
    cells = "".join(f"<td>{_cell(row.means[name])}</td>" for name, _ in HEADINGS)
    return (
        f"<tr><th>{place}. {in_html(row.name)}</th><td>{number(row.price)}<br><small>{number(low)} to {number(high)}"
        f"</small></td><td>{in_html(front)}<br><small>{row.front_share:.0%}</small></td>{cells}</tr>"
    )


def _cell(value: float) -> str:
    return number(value) if value == value else "–"


def _scenario_page(results: BenchmarkResults, rows: Sequence[MethodSummary], key: RunKey) -> str:
    """The curves of the best placed methods, and the numbers of all."""
    told = results.scenarios[key]
    drawn = [row.name for row in rows if results.scores[row.name][key].curves][:MOST]
    seconds = float(told["seconds"])
    charts = []
    for which, title in enumerate(TITLES):
        curves = []
        for color, name in zip(PALETTE, drawn):
            values = np.array(results.scores[name][key].curves[which])
            curves.append(ChartCurve(seconds * np.arange(len(values)) / len(values), values, color))
        charts.append(f"<figure>{chart(title, curves, seconds, logarithmic=which != 1)}</figure>")
    legend = "".join(f"<span>{swatch(color)}{in_html(name)}</span>" for color, name in zip(PALETTE, drawn))
    place = f" {told['place']}." if told["place"] else ""
    facts = f"{key.robot}, {key.kind}.{place} {told['exit']} · {1e3 * told['dt']:g} ms · {seconds:g} s"
    return _document(
        f"{key.robot}: {key.name}",
        f"<p>{in_html(facts)}</p><p class='key'>{legend}</p><div class='charts'>{''.join(charts)}</div>"
        f"{_scores_table(results, rows, key)}<p><a href='index.html'>All scenarios</a></p>",
    )


def _scores_table(results: BenchmarkResults, rows: Sequence[MethodSummary], key: RunKey) -> str:
    heads = "".join(f"<th>{in_html(title)}</th>" for _, title in HEADINGS)
    body = "".join(
        f"<tr><th>{in_html(row.name)}</th>{_score_cells(results.scores[row.name][key])}</tr>" for row in rows
    )
    return (
        f"<div class='scroll'><table><thead><tr><th>method</th>{heads}</tr></thead><tbody>{body}</tbody></table></div>"
    )


def _score_cells(score: RunScore) -> str:
    return "".join(f"<td>{_cell(getattr(score, name))}</td>" for name, _ in HEADINGS)


def _document(title: str, body: str) -> str:
    """A page without scripts."""
    return (
        f'<!DOCTYPE html><html lang="en"><head><meta charset="utf-8"><meta http-equiv="Content-Security-Policy" '
        f'content="{in_html(POLICY)}"><meta name="viewport" content="width=device-width, initial-scale=1">'
        f'<meta name="color-scheme" content="light dark"><link rel="icon" href="data:,"><title>{in_html(title)}</title>'
        f"<style>{asset('robustness.css')}</style></head><body><main><h1>{in_html(title)}</h1>{body}</main></body></html>\n"
    )
