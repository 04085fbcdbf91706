"""Tells what the benchmark found: tables, verdicts and a figure, printed and put into the page."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence

from benchmarks.report import OUT, command, machine, versions
from benchmarks.robustness import saved
from benchmarks.robustness.agreement import Agreement
from benchmarks.robustness.arms import HELD_OUT, TRAINING
from benchmarks.robustness.contenders import Contender
from benchmarks.tables import DOCS, markdown, publish
from robust_ik.display import plot_tradeoff, write_robustness_html
from robust_ik.simulation.robustness import KINDS, OBJECTIVES, BenchmarkResults, MethodSummary, by_class

NAME = "robustness"
SUBJECT = "SecondOrder"
"""Whose place is told in words."""
COLUMNS = (
    "method", "price", "95 %", "on the front", "error kept", "error lost", "leaves", "after [s]", "peak / limit",
    "chatter [1/s]", "steps over limits", "at rest / limit",
)  # fmt: skip
NEEDS = (
    ("stops near a singularity", "left", -1.0, "share of singular starts that are left"),
    ("shakes", "chatter", 1.0, "changes of sign of the acceleration, 1/s and joint"),
    ("does not come back, or ends off its path", "final", 1.0, "error at the end, rad scaled"),
    ("jumps", "speed", 1.0, "peak of the commanded speed over its limit"),
    ("leaves its path", "kept", 1.0, "error in kept directions, rad scaled"),
)  # fmt: skip
"""What a user sees, the number that says so, and its sign: less is better, or more."""
FEW = 5


def tell(
    results: BenchmarkResults, failures: Mapping[str, str], chosen: Mapping[str, Contender],
    agreements: Sequence[Agreement], *, page: str, write: bool,
) -> None:  # fmt: skip
    """Prints everything and saves it; into the page, and docs/benchmarks, if `write`.

    Args:
        results: Of all rows, rounded.
        failures: Why contenders have no row, by name.
        chosen: The tuned ones, by name.
        agreements: Of pairs; if there are none, nothing is told of them.
        page: File in docs.
        write: Whether to change it.
    """
    rows = results.summaries()
    parts = {
        "table": markdown(COLUMNS, [_cells(row) for row in rows]),
        "words": "\n".join(f"* {line}" for line in [*words(rows), *_missing(failures)]),
        "classes": markdown(("method", *KINDS), [_classes(results, row.name) for row in rows]),
        "settings": _settings(chosen),
    }
    if agreements:  # else the page keeps what it says of them
        parts["agreement"] = "\n".join(f"* {each.words}." for each in agreements)
    for mark, text in parts.items():
        publish(text, page, f"{NAME}_{mark}", write=write)
        print()
    needs = markdown(("your arm …", "measured by", "take", "beside `SecondOrder`"), list(_needs(rows)), text=True)
    publish(needs, "which_inverse.md", "needs", write=write)
    record = {
        "name": NAME, "command": command(), "machine": machine(), "versions": versions(),
        "settings": {"training": TRAINING, "held out": HELD_OUT},
        "tuned": {name: dict(each.parameters) for name, each in chosen.items()},
        "failures": dict(failures), "results": [_plain(row) for row in rows],
        "classes": {row.name: {kind: by_class(results.scores[row.name], kind) for kind in OBJECTIVES} for row in rows},
    }  # fmt: skip
    for folder in (OUT, DOCS / "benchmarks") if write else (OUT,):
        folder.mkdir(parents=True, exist_ok=True)
        (folder / f"{NAME}.json").write_text(json.dumps(_finite(record), indent=1) + "\n", encoding="utf-8")
        plot_tradeoff(rows, folder / f"{NAME}.svg")
        saved.save(results, folder)
    results.save(OUT / f"{NAME}_runs.json")
    write_robustness_html(OUT / NAME, results)


def words(rows: Sequence[MethodSummary]) -> list[str]:
    """Verdicts on SUBJECT and on the front, computed from the rows."""
    by_name = {row.name: row for row in rows}
    front = ", ".join(f"`{row.name}`" for row in rows if row.on_front)
    found = [f"On the Pareto front of the four numbers: {front}."]
    subject = by_name.get(SUBJECT)
    if subject is None:
        return found
    if subject.on_front:
        told = f"`{SUBJECT}` is on the front, and in {subject.front_share:.0%} of the resamples."
    else:
        beaten = ", ".join(f"`{name}`" for name in subject.beaten_by)
        told = (
            f"`{SUBJECT}` is not on the front: no worse in all four numbers and better in one: {beaten}; it is on the "
            f"front in {subject.front_share:.0%} of the resamples."
        )
    found.append(told)
    place = [row.name for row in rows].index(SUBJECT) + 1
    found.append(f"By price it is number {place} of {len(rows)}; the lowest price has `{rows[0].name}`.")
    for number in OBJECTIVES:
        best = min(rows, key=lambda row: row.means[number])
        if best is not subject:
            ahead = sum(row.means[number] < subject.means[number] for row in rows)
            found.append(
                f"{TITLES[number]}: {ahead} rows have less than its {subject.means[number]:.3g}, "
                f"`{best.name}` the least, {best.means[number]:.3g}."
            )
        else:
            found.append(f"{TITLES[number]}: it has the least, {subject.means[number]:.3g}.")
    return found


TITLES = {
    "kept": "Error in kept directions", "speed": "Peak speed over limit", "leave": "Seconds to leave",
    "chatter": "Chatter",
}  # fmt: skip


def _missing(failures: Mapping[str, str]) -> list[str]:
    return [f"{name} is not in the table: {reason}." for name, reason in failures.items()]


def _needs(rows: Sequence[MethodSummary]) -> list[tuple[str, ...]]:
    """For each thing that a user sees: the methods that show it least, of those with a low price."""
    subject = next((row for row in rows if row.name == SUBJECT), None)
    able = rows[: max(FEW, len(rows) // 2)]
    found = []
    for seen, number, sign, meaning in NEEDS:
        best = sorted(able, key=lambda row: sign * row.means[number])[:3]
        named = ", ".join(f"`{row.name}` {row.means[number]:.2g}" for row in best)
        own = "–" if subject is None else f"{subject.means[number]:.2g}"
        found.append((seen, meaning, named, own))
    return found


def _cells(row: MethodSummary) -> tuple[str, ...]:
    low, high = row.intervals["price"]
    name = f"**`{row.name}`**" if row.name == SUBJECT else f"`{row.name}`"
    front = f"{'yes' if row.on_front else 'no'}, {row.front_share:.0%}"
    means = row.means
    return (
        name, f"{row.price:.2f}", f"{low:.2g} to {high:.2g}", front, f"{means['kept']:.3f}", f"{means['lost']:.3f}",
        f"{means['left']:.0%}", f"{means['leave']:.2f}", f"{means['speed']:.2f}", f"{means['chatter']:.2f}",
        f"{means['violations']:.1%}", f"{means['rest']:.2g}",
    )  # fmt: skip


def _classes(results: BenchmarkResults, name: str) -> tuple[str, ...]:
    """Error kept and chatter for each class."""
    kept, shaken = (by_class(results.scores[name], number) for number in ("kept", "chatter"))
    return (f"`{name}`", *(f"{kept[kind]:.3f} / {shaken[kind]:.1f}" if kind in kept else "–" for kind in KINDS))


def _settings(chosen: Mapping[str, Contender]) -> str:
    """What methods are tuned to, a table, or a sentence that none is."""
    if not chosen:
        return "In these tables no method has been tuned: all are as they come."
    return markdown(("method", "tuned to"), [_setting(each) for each in chosen.values()], text=True)


def _setting(contender: Contender) -> tuple[str, str]:
    told = ", ".join(f"{name} = {value:g}" for name, value in contender.parameters)
    return f"`{contender.name}`", told or "its defaults"


def _plain(row: MethodSummary) -> dict[str, object]:
    return {**vars(row), "means": dict(row.means), "intervals": dict(row.intervals), "on_front": row.on_front}


def _finite(value: object) -> object:
    """The value with None in place of nan, as JSON has none."""
    if isinstance(value, Mapping):
        return {str(key): _finite(each) for key, each in value.items()}
    if isinstance(value, (list, tuple)):
        return [_finite(each) for each in value]
    return None if isinstance(value, float) and value != value else value
