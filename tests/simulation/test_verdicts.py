"""What became of a paper's claim is computed: the rule, and that no notebook types the word."""

import json
import re
from pathlib import Path

import pytest

from robust_ik.simulation.scenarios import verdict

NOTEBOOKS = sorted((Path(__file__).parents[2] / "notebooks").glob("*.ipynb"))
TYPED = re.compile(
    r"\*(?:\*?[^*{}\n]*\b)?(?:holds?|wrong|open)\b[^*{}\n]*\*|\bverdict\b(?!\()|\bholds? in kind\b|\bboth hold\b",
    re.IGNORECASE,
)
"""A verdict's word that is emphasised or announced, and not between the braces that compute it."""


@pytest.mark.parametrize(
    "outcomes, stands_in, cut, word",
    [
        (True, False, False, "holds"),
        (True, True, False, "holds in kind"),
        (False, False, False, "wrong"),
        (False, True, False, "open"),
        ([True, True], False, False, "holds"),
        ([True, False], False, False, "open"),
        ([True, False], True, False, "open"),
        (None, False, False, "open"),
        (True, False, True, "open"),
        (False, False, True, "open"),
    ],
)
def test_a_verdict_follows_from_outcomes_alone(outcomes, stands_in, cut, word):
    assert verdict(outcomes, stands_in=stands_in, cut=cut) == word


def test_a_verdict_on_nothing_is_refused():
    with pytest.raises(ValueError, match="at least one outcome"):
        verdict([])


def sources(path):
    return ["".join(cell["source"]) for cell in json.loads(path.read_text(encoding="utf-8"))["cells"]]


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_no_notebook_types_a_verdict(path):
    texts = sources(path)
    assert sum(text.count("{verdict(") for text in texts) >= 5
    imports = re.compile(r"^from robust_ik\.simulation\.scenarios import .*$", re.MULTILINE)
    assert [found for text in texts for found in TYPED.findall(imports.sub("", text))] == []


@pytest.mark.parametrize(
    "text",
    [
        "*Verdict: holds.* The",
        "**Hold.** At",
        "That SGIM\nfails **holds in kind**, from",
        "**Both hold**",
        "*Open.* The paper",
    ],
)
def test_typed_verdicts_are_seen(text):
    assert TYPED.search(text)
