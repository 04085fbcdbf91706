"""TOML whose reading takes the square of its length is refused at once, all other is read."""

import tomllib

import pytest

import robust_ik as rik
from robust_ik.description import toml_size_limits as toml_bounds
from robust_ik.description.dh.dh_toml import table_from_toml
from robust_ik.description.toml_size_limits import read_toml
from robust_ik.simulation.scenarios import read_scenario

LONG = {
    "a key": "a" + ".a" * 100_000 + " = 1",
    "a table": "[" + "a . " * 100_000 + "a]",
    "a list of tables": "[[" + "a." * 100_000 + "a]]",
    "in quotes": '",]".' * 100_000 + "a = 1",
    "in other quotes": "'=#'." * 100_000 + "a = 1",
    "escaped": '"\\"".' * 100_000 + "a = 1",
    "inside": "x = {" + "a." * 100_000 + "a = 1}",
}


@pytest.mark.parametrize("text", LONG)
def test_a_key_of_very_many_parts_is_refused_before_it_is_read(text, monkeypatch, tmp_path):
    monkeypatch.setattr(toml_bounds.tomllib, "loads", None)
    with pytest.raises(ValueError, match="over 100 parts"):
        read_toml(LONG[text])
    (tmp_path / "run.toml").write_text(LONG[text])
    with pytest.raises(rik.LoadError, match="over 100 parts"):
        read_scenario(tmp_path / "run.toml")


@pytest.mark.parametrize("text", ["a = " + "[" * 100_000, "a = " + "{a=" * 100_000])
def test_what_is_nested_too_deeply_is_refused(text):
    with pytest.raises(ValueError, match="nested too deeply"):
        read_toml(text)
    with pytest.raises(rik.DHError, match="over 200000|a line of over"):
        table_from_toml(text)


def test_long_words_numbers_and_sentences_are_no_keys():
    sentences = "A sentence ends here. " * 500 + "a.b. c.d ... " * 300
    text = f"note = '{sentences}'\nword = '{'a' * 500_000}'\nb = [{'1.5, ' * 50_000}]\nc.d.e = 1\n# {'x. y z.' * 500}"
    assert read_toml(text) == tomllib.loads(text)
