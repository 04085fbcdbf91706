"""Files as exporters and people get them wrong: what Pinocchio reads is read alike, or refused with reason."""

import random

import pytest

from tests.attack import exporter_mistakes
from tests.attack.exporter_mistakes import MISTAKES, attack, bases, failure, mutated


def test_what_pinocchio_reads_is_read_alike_or_refused_for_a_stated_reason():
    assert attack(2 * len(MISTAKES), 0, lambda text: None) == []


def test_unspoilt_files_are_read_alike():
    assert [tip for text, tip in bases() if failure(text.encode(), tip, 0)] == []


@pytest.mark.parametrize("mistake", MISTAKES, ids=lambda mistake: mistake.__name__)
def test_every_mistake_is_made(mistake):
    text, _ = bases()[0]
    assert any(mistake(text, random.Random(seed)) != text for seed in range(20))


def test_the_same_number_makes_the_same_file():
    assert mutated(7) == mutated(7)
    assert len({mutated(number)[1] for number in range(50)}) > 45


def test_a_difference_and_a_refusal_without_reason_are_found(monkeypatch):
    text, tip = next((text, tip) for text, tip in bases() if tip == "tool0")
    data = text.encode()
    read = exporter_mistakes.parse_urdf
    turned = text.replace('xyz="0 1 0"', 'xyz="0 0 1"')
    assert turned != text
    monkeypatch.setattr(exporter_mistakes, "parse_urdf", lambda data: read(turned))
    assert "poses differ" in failure(data, tip, 0)
    monkeypatch.setattr(exporter_mistakes, "parse_urdf", lambda data: read("<robot/>"))
    assert "Pinocchio reads it: URDF text: it has no <link>" in failure(data, tip, 0)
    monkeypatch.setattr(exporter_mistakes, "parse_urdf", lambda data: {}["x"])
    assert failure(data, tip, 0).startswith("KeyError")
