"""Claim: one statement of a paper, the numbers measured for it, and the verdict that follows from them."""

from __future__ import annotations

import itertools
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cache
from string import Formatter
from types import CodeType, MappingProxyType
from typing import Any

import numpy as np

from benchmarks.claims.spread import Spread
from robust_ik.simulation.scenarios import verdict

FUNCTIONS = {"abs": abs, "min": min, "max": max, "len": len, "round": round}
TYPED = re.compile(r"(?<!Sec\. )\b\d+(\.\d|e[-+]?\d)")
"""A decimal number: in a text it must come from the numbers."""
Number = float | int | bool | str | Spread


@dataclass(frozen=True)
class Claim:
    """One line of the page. Nobody types its verdict: it follows from the numbers.

    A condition is an expression over the names of the numbers, and says what the paper says: `kim < chiaverini`. It
    must hold at both ends of every spread. `robust_ik.simulation.scenarios.verdict` has the rule.

    Attributes:
        what: What is claimed, with its place in the paper.
        paper: The paper's number or words.
        numbers: What was measured, by name; a word or a `Spread` is a number, too.
        says: The text under "here": a template, its fields are the numbers.
        holds: The condition; where the text can be read in several ways, a condition for each reading.
        why: One line, a template as well.
        kind: What stands in for what the paper does not say, or in what sense only it can be tried.
        cut: What is missing from our copy of the paper, without which nothing can be decided.
    """

    what: str
    paper: str
    numbers: Mapping[str, Number]
    says: str
    holds: str | Mapping[str, str]
    why: str = ""
    kind: str = ""
    cut: str = ""

    def __post_init__(self) -> None:
        plain = {name: _plain(number) for name, number in self.numbers.items()}
        object.__setattr__(self, "numbers", MappingProxyType(plain))
        for template in (self.says, self.why):
            if typed := TYPED.search("".join(text for text, *_ in Formatter().parse(template))):
                raise ValueError(f"{self.what}: {typed[0]}… is typed in {template!r}: it must be one of the numbers")
        if "|" in "".join(self.row):
            raise ValueError(f"{self.what}: a vertical bar would end its cell of the table")

    @property
    def ours(self) -> str:
        """What the experiment gives here."""
        return self.says.format(**self.numbers)

    @property
    def readings(self) -> Mapping[str, str]:
        """A condition for each reading of the text."""
        return {"": self.holds} if isinstance(self.holds, str) else self.holds

    @property
    def verdict(self) -> str:
        """What became of it."""
        outcomes = {self.outcome(condition) for condition in self.readings.values()}
        return verdict(outcomes, stands_in=bool(self.kind), cut=bool(self.cut))

    def outcome(self, condition: str) -> bool | None:
        """Whether a condition holds; None where it does at some ends of the spreads only."""
        return _outcome(condition, self.numbers)

    @property
    def reason(self) -> str:
        """The line under "why", with what stands in, and with what each reading gives where they differ."""
        outcomes = {name: self.outcome(condition) for name, condition in self.readings.items()}
        apart = len(set(outcomes.values())) > 1
        words = {True: "holds", False: "does not", None: "undecided"}
        read = ", ".join(f"read as {name}: {words[so]}" for name, so in outcomes.items()) if apart else ""
        return "; ".join(filter(None, (self.why.format(**self.numbers), read, self.kind, self.cut)))

    @property
    def row(self) -> tuple[str, str, str, str, str]:
        """Its cells."""
        return self.what, self.paper, self.ours, self.verdict, self.reason

    def opposite(self, reading: str = "") -> Claim | None:
        """The same claim with numbers spoilt so that a condition turns round; None if no number can do that."""
        condition = self.readings[reading]
        told = [name for name in self.numbers if name in _names(condition)]
        wanted = self.outcome(condition) is not True
        for many in range(1, len(told) + 1):
            for chosen in itertools.combinations(told, many):
                for values in itertools.product(*(_spoilt(self.numbers, name) for name in chosen)):
                    spoilt = {**self.numbers, **dict(zip(chosen, values))}
                    if _outcome(condition, spoilt) is wanted:
                        return replace(self, numbers=spoilt)
        return None


@cache
def _compiled(condition: str) -> CodeType:
    return compile(condition, condition, "eval")


def _names(condition: str) -> tuple[str, ...]:
    return _compiled(condition).co_names


def _outcome(condition: str, numbers: Mapping[str, Number]) -> bool | None:
    """Whether a condition holds at all ends of the spreads that it names, at none, or (None) at some."""
    told = {name: number for name, number in numbers.items() if name in _names(condition)}
    ends = [[each.low, each.high] if isinstance(each, Spread) else [each] for each in told.values()]
    found = set()
    for values in itertools.product(*ends):
        scope = {"__builtins__": {}, **FUNCTIONS, **dict(zip(told, values))}
        found.add(bool(eval(_compiled(condition), scope)))
        if len(found) > 1:
            return None
    return found.pop()


def _plain(number: Any) -> Number:
    return number.item() if isinstance(number, np.generic) else number


def _spoilt(numbers: Mapping[str, Number], name: str) -> Iterator[Number]:
    """Other values of a number: those of the other numbers, none, less, more, the other way round."""
    own = numbers[name]
    if isinstance(own, bool):
        yield not own
    elif isinstance(own, str):
        yield from (each for other, each in numbers.items() if isinstance(each, str) and other != name)
        yield own + " no more"
    else:
        for other, each in numbers.items():
            if other != name and not isinstance(each, bool | str):
                yield each
        for change in (lambda x: 0 * x, lambda x: -x, lambda x: 1000 * x, lambda x: x / 1000, lambda x: x + 1):
            yield Spread(tuple(map(change, own.runs))) if isinstance(own, Spread) else change(own)
