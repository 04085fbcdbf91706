"""Claims kept with their numbers, and how a fresh measurement compares with them."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from benchmarks.claims.claim import Claim, Number
from benchmarks.claims.spread import Spread
from benchmarks.tables import markdown

FOLDER = Path(__file__).parent / "measured"
COLUMNS = ("claim", "paper", "here", "verdict", "why")
PARTS = ("what", "paper", "says", "holds", "why", "kind", "cut")


def names() -> list[str]:
    """The papers whose claims are kept."""
    return sorted(path.stem for path in FOLDER.glob("paper_*.json"))


def read(name: str) -> list[Claim]:
    """The claims of a paper as they were measured last; none if never."""
    path = FOLDER / f"{name}.json"
    kept = json.loads(path.read_text(encoding="utf-8")) if path.exists() else []
    return [Claim(**{**each, "numbers": {key: _number(x) for key, x in each["numbers"].items()}}) for each in kept]


def write(name: str, claims: Sequence[Claim]) -> None:
    """Keeps the claims of a paper."""
    FOLDER.mkdir(exist_ok=True)
    kept = [
        {part: _json(getattr(each, part)) for part in (*PARTS, "numbers") if getattr(each, part)} for each in claims
    ]
    text = json.dumps(kept, indent=1, ensure_ascii=False) + "\n"
    (FOLDER / f"{name}.json").write_text(text, encoding="utf-8")


def table(claims: Sequence[Claim]) -> str:
    """The page's table."""
    return markdown(COLUMNS, [each.row for each in claims], text=True)


def settled(fresh: Claim, kept: Claim) -> Claim:
    """The fresh claim, with the kept spread wherever the two spreads agree."""
    numbers = dict(fresh.numbers)
    for name, number in numbers.items():
        before = kept.numbers.get(name)
        if isinstance(number, Spread) and isinstance(before, Spread) and number.near(before):
            numbers[name] = before
    return replace(fresh, numbers=numbers)


def agree(fresh: Claim, kept: Claim) -> bool:
    """Whether the page would say the same, digit for digit, but for ranges that overlap."""
    same = all(getattr(fresh, part) == getattr(kept, part) for part in PARTS)
    return same and settled(fresh, kept).row == kept.row


def renewed(fresh: Sequence[Claim], kept: Sequence[Claim]) -> list[Claim]:
    """The fresh claims, but the kept one wherever they agree: a page does not change without a reason."""
    before = {each.what: each for each in kept}
    return [before[each.what] if each.what in before and agree(each, before[each.what]) else each for each in fresh]


def differences(fresh: Sequence[Claim], kept: Sequence[Claim]) -> list[str]:
    """What a fresh measurement says differently, a line for each claim."""
    now, before = ({each.what: each for each in claims} for claims in (fresh, kept))
    lines = [f"{what}: no longer measured" for what in before if what not in now]
    for what, each in now.items():
        if what not in before:
            lines.append(f"{what}: not on the page")
        elif not agree(each, before[what]):
            lines.append(f"{what}:\n  page  {' | '.join(before[what].row[2:])}\n  fresh {' | '.join(each.row[2:])}")
    return lines


def _json(part: Any) -> Any:
    if isinstance(part, Spread):
        return {"runs": list(part.runs)}
    return part if isinstance(part, str | int | float) else {name: _json(each) for name, each in part.items()}


def _number(kept: Any) -> Number:
    return Spread(tuple(kept["runs"])) if isinstance(kept, dict) else kept
