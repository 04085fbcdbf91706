import ast
import json
import subprocess
import sys
from pathlib import Path

import pytest

import robust_ik as rik

ROOT = Path(rik.__file__).parent
HEAVY = {
    "scipy", "qpsolvers", "numba", "llvmlite", "matplotlib", "meshcat", "tornado", "flint", "typer", "rich", "yourdfpy",
    "trimesh", "lxml", "pinocchio", "coal",
}  # fmt: skip


def after(program: str) -> set[str]:
    """The packages that are loaded in a process of its own once the program has run."""
    program += "\nimport json, sys; print(json.dumps(sorted({name.split('.')[0] for name in sys.modules})))"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, check=True)
    return set(json.loads(done.stdout.splitlines()[-1]))


def test_importing_the_package_loads_none_of_what_it_needs():
    assert not after("import robust_ik as rik; rik.__all__, dir(rik), rik.__version__") & HEAVY


def test_inverses_and_resolvers_load_no_compiler_and_no_solver():
    program = "import robust_ik as rik; rik.JParse(), rik.TaskPriority(limiter=rik.Scaling()), rik.explain, rik.svd"
    assert not after(program) & (HEAVY - {"lxml"})


@pytest.mark.parametrize("robot", ["panda", "planar_2r"])
def test_loading_a_robot_compiles_nothing_solves_nothing_and_reads_no_mesh(robot):
    loaded = after(f"import robust_ik as rik; assert rik.load({robot!r}).n")
    assert not loaded & (HEAVY - {"pinocchio", "coal", "lxml"} | {"networkx"})


def test_the_command_is_there_before_the_mathematics():
    loaded = after("from robust_ik.cli import app; assert app.registered_commands")
    assert not loaded & (HEAVY - {"typer", "rich"} | {"numpy"})


def test_listing_robots_builds_none():
    loaded = after("from robust_ik.cli import app; app(['robots'], standalone_mode=False)")
    assert "lxml" in loaded
    assert not loaded & (HEAVY - {"typer", "rich", "lxml"} | {"networkx"})


def test_every_public_name_is_there():
    for name in rik.__all__:
        assert getattr(rik, name) is not None
    assert set(rik.__all__) <= set(dir(rik))
    assert len(set(rik.__all__)) == len(rik.__all__)


def test_the_one_table_says_each_name_once_and_shows_it_to_type_checkers():
    stub = ast.parse((ROOT / "__init__.pyi").read_text(encoding="utf-8"))
    names = [alias for each in stub.body if isinstance(each, ast.ImportFrom) for alias in each.names]
    assert all(alias.asname == alias.name for alias in names)  # without "as" they are private to the table
    assert sorted(alias.name for alias in names) == sorted(set(rik.__all__) - {"__version__"})
    assert (ROOT / "py.typed").exists()


def test_no_public_name_is_hidden_by_a_module_of_that_name():
    modules = {path.stem for path in ROOT.glob("*.py")} | {path.parent.name for path in ROOT.glob("*/__init__.py")}
    assert {name for name in rik.__all__ if not hasattr(getattr(rik, name), "__path__")}.isdisjoint(modules)


def test_modules_are_attributes_without_an_import_of_their_own():
    assert after("import robust_ik as rik; rik.inverses.JParse, rik.certificates.certify, rik.errors.InputError")
    assert rik.inverses.JParse is rik.JParse


def test_a_name_that_does_not_exist_is_an_attribute_error_and_no_import_error():
    with pytest.raises(AttributeError, match="'robust_ik' has no attribute 'Pseudoinverse'"):
        rik.Pseudoinverse  # noqa: B018
    with pytest.raises(ImportError, match="cannot import name 'Pseudoinverse'"):
        from robust_ik import Pseudoinverse  # noqa: F401
    assert not hasattr(rik, "_private")


def test_a_star_brings_the_public_names():
    names: dict[str, object] = {}
    exec("from robust_ik import *", names)
    assert set(rik.__all__) <= set(names)
