"""Tables for the terminal, by rich: facts of a robot, lists of robots and scenarios, comparisons of runs."""

from __future__ import annotations

import inspect
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
from rich import box
from rich.table import Table

from robust_ik.description.joint_tree import Mesh
from robust_ik.errors.safe_text import plain, visible

if TYPE_CHECKING:  # a list of names needs neither robots nor inverses
    from robust_ik.description.catalog import Entry
    from robust_ik.inverses import RobustInverse
    from robust_ik.paths import PathPlan
    from robust_ik.robot.robot import Robot
    from robust_ik.simulation.robustness import MethodSummary
    from robust_ik.simulation.trajectory import Trajectory

MOST_NOTES = 20
"""Most notes that `info` prints. Chosen: with the facts above they fill about a screen; the others are counted."""


def comparison(runs: Mapping[str, Trajectory]) -> Table:
    """One row per method: joint speed, tracking error, smallest σ, time per step. Fits 80 columns."""
    table = Table(
        box=box.SIMPLE_HEAD,
        padding=0,
        caption="Largest joint speed in rad/s (m/s where it slides), and as a multiple of the joint's limit, which "
        "nothing enforces here; largest and final tracking error, "
        "smallest singular value met, median time of a control step.",
        caption_justify="left",
    )
    table.add_column("method", no_wrap=True)
    errors = ("error\n[mm]", "final\n[mm]", "error\n[deg]", "final\n[deg]")
    headings = ("peak\nspeed", "× its\nlimit", *errors, "least\nσ", "step\n[µs]")
    for heading in headings:
        table.add_column(plain(heading), justify="right", no_wrap=True)
    for name, run in runs.items():
        final = np.linalg.norm(run.final_error.reshape(2, 3), axis=-1)
        table.add_row(
            plain(name),
            f"{run.largest_speed:.3g}" if run.largest_speed < 1e4 else f"{run.largest_speed:.0e}",
            f"{run.largest_speed_ratio:.2g}" if run.largest_speed_ratio else "–",
            f"{1e3 * run.position_error.max():.1f}",
            _small(1e3 * final[0]),
            f"{np.degrees(run.rotation_error.max()):.1f}",
            _small(np.degrees(final[1])),
            f"{run.smallest_sigma:.0e}",
            f"{1e6 * run.seconds_per_step:.0f}",
        )
    return table


def path_pieces(plan: PathPlan) -> Table:
    """One row per piece of a plan. Fits 80 columns."""
    table = Table(box=box.SIMPLE_HEAD, padding=0)
    headings = ("piece", "from\npose", "to\npose", "configurations", "joint travel\n[rad]", "least σ/σ₁")
    for heading in headings:
        table.add_column(plain(heading), justify="right", no_wrap=True)
    for number, piece in enumerate(plan.pieces):
        ends, travel, margin = (f"{piece.s[0]:.5g}", f"{piece.s[-1]:.5g}"), f"{piece.travel:.3g}", f"{piece.margin:.1e}"
        table.add_row(str(number), *ends, str(len(piece)), travel, margin)
    return table


def robustness(rows: Sequence[MethodSummary]) -> Table:
    """One row per method of the robustness benchmark, ranked by price. Fits 80 columns."""
    table = Table(
        box=box.SIMPLE_HEAD,
        padding=0,
        caption="Ranked by price: the mean of kept error / 0.02, peak / limit, seconds to leave, and chatter / 2 per "
        "second. Errors in radians, metres divided by the arm's length. Front: whether no other method is no worse "
        "in all four numbers and better in one, and in how many resamples.",
        caption_justify="left",
    )
    table.add_column("method", no_wrap=True)
    for heading in (
        "price",
        "95 %",
        "front",
        "error\nkept",
        "error\nlost",
        "leave\n[s]",
        "peak /\nlimit",
        "chatter\n[1/s]",
    ):
        table.add_column(plain(heading), justify="right", no_wrap=True)
    for row in rows:
        low, high = row.intervals["price"]
        numbers = (f"{row.means[name]:.2g}" for name in ("kept", "lost", "leave", "speed", "chatter"))
        front = f"{'yes' if row.on_front else 'no'} {row.front_share:.0%}"
        table.add_row(plain(row.name), f"{row.price:.2f}", f"{low:.2g}–{high:.2g}", front, *numbers)
    return table


def scenarios(titles: Mapping[str, str]) -> Table:
    """One row per scenario that comes with the package."""
    table = Table(title="Scenarios", title_justify="left", box=box.SIMPLE_HEAD, padding=(0, 1, 0, 0))
    table.add_column("name", no_wrap=True)
    table.add_column("what happens")
    for name, title in titles.items():
        table.add_row(plain(name), plain(title))
    return table


def _small(error: float) -> str:
    return f"{error:.1f}" if error >= 0.05 else f"{error:.0e}" if error > 1e-9 else "0"


def inverses_table(classes: Iterable[type[RobustInverse]], *, wide: bool) -> Table:
    """One row per inverse with all its promises; if not wide, only its formula and its source."""
    table = Table(box=box.SIMPLE_HEAD, padding=(0, 1, 0, 0), show_lines=False)
    shown = range(len(INVERSE_COLUMNS)) if wide else (0, 1, len(INVERSE_COLUMNS) - 1)
    for column in shown:
        table.add_column(INVERSE_COLUMNS[column], no_wrap=column == 0, ratio=0 if column == 0 else 1)
    for row in _inverse_rows(classes):
        table.add_row(*(plain(row[column]) for column in shown))
    return table


def inverse_details(each: type[RobustInverse]) -> Table:
    """The promises of one inverse, and its parameters with their defaults."""
    table = Table.grid(padding=(0, 2))
    table.add_column(style="bold", no_wrap=True)
    table.add_column()
    (row,) = _inverse_rows([each])
    for heading, cell in zip(INVERSE_COLUMNS, row):
        table.add_row(heading, plain(cell))
    for name, parameter in inspect.signature(each).parameters.items():
        default = "needed" if parameter.default is parameter.empty else f"default {parameter.default!r}"
        table.add_row(plain(name), plain(default))
    return table


def inverses_markdown(classes: Iterable[type[RobustInverse]]) -> str:
    """The table of inverses as Markdown, as in the README."""
    rows = [INVERSE_COLUMNS, ("---",) * len(INVERSE_COLUMNS)]
    rows += [(f"`{row[0]}`", *(cell.replace("|", "\\|") for cell in row[1:])) for row in _inverse_rows(classes)]
    return "\n".join(f"| {' | '.join(row)} |" for row in rows)


INVERSE_COLUMNS = (
    "inverse",
    "φ(σ), or what it does",
    "largest gain",
    "at σ → 0",
    "exact where",
    "continuity",
    "source",
)


def _inverse_rows(classes: Iterable[type[RobustInverse]]) -> Iterable[tuple[str, ...]]:
    for each in classes:
        card = each.card
        promises = (card.formula, card.largest_gain, card.gain_at_zero, card.exact, card.continuity)
        yield (each.__name__, *promises, each.source)


def robots(entries: Iterable[tuple[Entry, str, str]]) -> Table:
    """One row per robot that can be loaded by name: entry, joints, tip."""
    table = Table(title="Robots that load by name", title_justify="left", box=box.SIMPLE_HEAD, padding=0)
    table.add_column("name", no_wrap=True)
    table.add_column("joints", justify="right")
    table.add_column("tip")
    table.add_column("source")
    for entry, joints, tip in entries:
        table.add_row(plain(entry.name), joints, plain(tip), plain(entry.source))
    return table


def joints(robot: Robot) -> Table:
    """The chain: joints with type and limits."""
    table = Table(title="Joints that move the tip" if robot.tip else "Joints", title_justify="left")
    for heading in ("joint", "type", "lower", "upper", "speed", "unit"):
        table.add_column(heading, justify="left" if heading in ("joint", "type", "unit") else "right")
    for index, name in enumerate(robot.joint_names):
        kind = robot.description.joint[name].kind
        limits = (robot.lower[index], robot.upper[index], robot.velocity_limit[index])
        table.add_row(
            plain(name),
            kind,
            *(_limit(limit) for limit in limits),
            "m, m/s" if kind == "prismatic" else "rad, rad/s",
        )
    return table


def _limit(value: float) -> str:
    return f"{value:.4g}" if np.isfinite(value) else "–"


def facts(robot: Robot) -> Table:
    """The facts that a user checks first: tip, rows, σ and manipulability at rest, reach."""
    table = Table.grid(padding=(0, 2))
    table.add_column(style="bold")
    table.add_column(overflow="fold")
    for name, value in _facts(robot):
        table.add_row(name, plain(value))
    return table


def _facts(robot: Robot) -> Iterable[tuple[str, str]]:
    yield "source", visible(robot.description.source)
    yield "joints", f"{robot.n} independent (nq = {robot.nq})"
    yield "leaves", ", ".join(map(visible, robot.description.leaves))
    if robot.tip is not None:
        yield from _tip_facts(robot)
    missing = missing_meshes(robot)
    meshes = len(list(_meshes(robot)))
    if meshes:
        yield "meshes", f"{meshes - len(missing)} of {meshes} found" + "".join(f"\n{visible(line)}" for line in missing)
    if robot.notes:
        more = len(robot.notes) - MOST_NOTES
        shown = [visible(note) for note in robot.notes[:MOST_NOTES]]
        yield "notes", "\n".join([*shown, *([f"… and {more} more"] if more > 0 else [])])


def _tip_facts(robot: Robot) -> Iterable[tuple[str, str]]:
    from robust_ik.kinematics.svd import condition_number, svd
    from robust_ik.robot.reach import find_reach

    reach = find_reach(robot)
    J = robot.jacobian(robot.rest)
    s = svd(J).s
    condition = float(condition_number(J))
    yield "tip", visible(robot.tip)
    yield "size", f"{robot.size:.3g} m (length scale {robot.length_scale:.3g} m)"
    yield "task rows", " ".join(robot.rows)
    yield "rest joints", "  ".join(f"{value:.4g}" for value in robot.joint_values(robot.rest))
    yield "tip at rest", "  ".join(f"{value:.4g}" for value in robot.pose(robot.rest)[:3, 3].round(9) + 0.0) + " m"
    yield "σ at rest", "  ".join(f"{value:.3g}" for value in s)
    yield "manipulability", f"{np.prod(s):.3g}"
    yield "condition", f"{condition:.3g}" if np.isfinite(condition) else "infinite: the rest is singular"
    center = ", ".join(f"{x:.3g}" for x in reach.center)
    yield "reach", f"at least {reach.distance:.4g} m from ({center}), within the joint limits"


def missing_meshes(robot: Robot) -> list[str]:
    """The meshes that were not found, one line each: name and reason."""
    return list(dict.fromkeys(f"{mesh.name}: {mesh.problem}" for mesh in _meshes(robot) if mesh.path is None))


def _meshes(robot: Robot) -> Iterable[Mesh]:
    return (visual.shape for visual in robot.description.visuals if isinstance(visual.shape, Mesh))
