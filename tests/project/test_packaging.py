"""What is given away holds what its own tests need."""

import re
import tomllib
from pathlib import Path

ROOT = Path(__file__).parents[2]
ALWAYS = {"pyproject.toml"}
"""What the build puts in whatever is said."""


def test_a_source_distribution_holds_all_that_the_tests_and_the_makefile_name():
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    listed = {name.strip("/") for name in settings["tool"]["hatch"]["build"]["targets"]["sdist"]["include"]}
    assert all((ROOT / name).exists() for name in listed)
    texts = [path.read_text(encoding="utf-8") for path in (*(ROOT / "tests").rglob("*.py"), ROOT / "Makefile")]
    there = {path.name for path in ROOT.iterdir() if not path.name.endswith(("_cache", ".egg-info"))}
    words = re.compile(r"""["']([\w.-]+)["'/]|from (\w+)[ .]""")
    quoted = {name for text in texts for found in words.findall(text) for name in found}
    assert {"docs", "benchmarks", "README.md", "Makefile"} <= quoted & there
    assert quoted & there - {".git", ".venv", "out", "dist"} <= listed | ALWAYS
